// ToolShape: kinds, measures and errors; scenes that get a tool shape.
#include "haptics/tool/tool_shape.h"

#include <cmath>
#include <gtest/gtest.h>
#include <set>

#include "haptics/scene/touch_scene.h"

namespace trephine::haptics {
namespace {

using glm::dvec3;

TEST(ToolShape, HasOneKindPerGeometry) {
  const ToolShape point, ball(2.5), set(std::vector<ToolShape::Ball>{{{0, 0, 3}, 1}, {{0, 4, 0}, 1}});
  EXPECT_TRUE(point.is_point());
  EXPECT_EQ(point.radius(), 0);
  EXPECT_EQ(point.freedom(), Freedom::three);
  EXPECT_TRUE(ToolShape(0.0).is_point());
  EXPECT_EQ(ball.kind(), ToolShape::Kind::ball);
  EXPECT_EQ(ball.radius(), 2.5);
  EXPECT_EQ(ball.extent(), 2.5);
  EXPECT_TRUE(ball.balls().empty());
  EXPECT_EQ(set.freedom(), Freedom::six);
  EXPECT_EQ(set.arm(), 4);
  EXPECT_EQ(set.extent(), 5);
  EXPECT_EQ(set.gyration_square(), 400);  // mm2, the minimum
  EXPECT_EQ(ToolShape(std::vector<ToolShape::Ball>{{{0, 0, 30}, 1}, {{0, 0, 0}, 1}}).gyration_square(), 450);
  EXPECT_EQ(set.centres(), (std::vector<dvec3>{{0, 0, 3}, {0, 4, 0}}));
}

TEST(ToolShape, FingerprintsDistinguishShapes) {
  const auto both = [](double radius, const dvec3& at) {
    return ToolShape(std::vector<ToolShape::Ball>{{{0, 0, 0}, 1}, {at, radius}});
  };
  const ToolShape all[] = {ToolShape(),         ToolShape(1.0),
                           ToolShape(2.0),      ToolShape(std::vector<ToolShape::Ball>{{{0, 0, 0}, 1}}),
                           both(1, {0, 0, 1}),  both(1, {0, 1, 0}),
                           both(0.5, {0, 1, 0})};
  std::set<std::uint64_t> fingerprints;
  for (const ToolShape& one : all) {
    fingerprints.insert(one.fingerprint());
    for (const ToolShape& other : all) EXPECT_EQ(one == other, &one == &other);
  }
  EXPECT_EQ(fingerprints.size(), std::size(all));
}

TEST(ToolShape, InvalidBallsAreRefusedWithAReason) {
  const auto message = [](double radius, const std::vector<dvec3>& centres) {
    const auto tool = make_tool(radius, centres);
    return tool ? std::string() : tool.error().message();
  };
  EXPECT_EQ(message(0, {}), "");
  EXPECT_EQ(message(1, {{0, 0, 300}}), "");
  EXPECT_NE(message(0, {{0, 0, 0}}).find("needs a radius"), std::string::npos);
  EXPECT_NE(message(std::nan(""), {{0, 0, 0}}).find("needs a radius"), std::string::npos);
  EXPECT_NE(message(1, std::vector<dvec3>(17)).find("too many balls"), std::string::npos);
  EXPECT_NE(message(1, {{0, 0, 301}}).find("too far"), std::string::npos);
  EXPECT_NE(message(1, {{0, std::nan(""), 0}}).find("too far"), std::string::npos);
}

TEST(ToolShape, AScenesOffsetFieldsAreOfOneRadius) {
  TouchScene scene;
  const auto mixed = make_tool(std::vector<ToolShape::Ball>{{{0, 0, 0}, 1}, {{0, 0, 3}, 2}}).value();
  EXPECT_FALSE(mixed->has_equal_radii());
  EXPECT_EQ(mixed->radius(), 2);
  const Status error = set_tool(scene, mixed);
  ASSERT_TRUE(error.has_value());
  EXPECT_NE(error->message().find("different radii"), std::string::npos);
  EXPECT_TRUE(scene.tool->is_point());  // unchanged
  const auto equal = make_tool(1, std::vector<dvec3>{{0, 0, 0}, {0, 0, 3}}).value();
  EXPECT_FALSE(set_tool(scene, equal).has_value());
  EXPECT_EQ(scene.tool, equal);
}

}  // namespace
}  // namespace trephine::haptics
