// PositionMarking: positions are counted, removed and finished, and shown with the length of their line.
#include "apps/view/position_marking.h"

#include <gtest/gtest.h>

namespace trephine::view {
namespace {

using glm::dvec3;
using Request = PositionMarking::Request;

struct Marked {
  int count = 0;
  PositionMarking::Positions positions;
};

std::function<void(const PositionMarking::Positions&)> into(Marked& marked) {
  return [&marked](const PositionMarking::Positions& positions) {
    ++marked.count, marked.positions = positions;
  };
}

std::string label(const PositionMarking& marking, const std::optional<dvec3>& next = std::nullopt) {
  const sim::Overlays overlays = marking.overlays(next);
  return overlays.empty() || overlays[0].labels.empty() ? "" : overlays[0].labels[0].text;
}

TEST(PositionMarking, ARulerEndsWithItsSecondPosition) {
  PositionMarking marking;
  EXPECT_EQ(marking.prompt(), "");
  Marked marked;
  marking.begin({"Ruler", 2, 2}, into(marked));
  EXPECT_EQ(marking.prompt(), "Ruler: click position 1 of 2. Esc cancels.");
  marking.add({1, 2, 3});
  marking.add({1, 2, 3});
  EXPECT_EQ(marking.positions().size(), 1u) << "the same position again";
  EXPECT_FALSE(marking.finish()) << "too few";
  EXPECT_EQ(label(marking, dvec3(4, 6, 3)), "5.0 mm");
  marking.add({4, 6, 3});
  EXPECT_EQ(marked.count, 1);
  EXPECT_EQ(marked.positions, (PositionMarking::Positions{{1, 2, 3}, {4, 6, 3}}));
  EXPECT_FALSE(marking.is_active());
  EXPECT_TRUE(marking.overlays(dvec3(0)).empty());
}

TEST(PositionMarking, ALineOfAnyLengthIsFinishedByTheUser) {
  PositionMarking marking;
  Marked marked;
  Request request{"Area", 3};
  request.quantity = Request::Quantity::outline;
  marking.begin(request, into(marked));
  for (const dvec3& at : {dvec3(0), dvec3(3, 0, 0), dvec3(9, 9, 9)}) marking.add(at);
  marking.remove_last();
  marking.add({3, 4, 0});
  EXPECT_EQ(label(marking), "outline 12.0 mm") << "closed: 3, 4 and 5 mm";
  EXPECT_NE(marking.prompt().find("Enter finishes"), std::string::npos);
  EXPECT_TRUE(marking.finish());
  EXPECT_EQ(marked.positions.size(), 3u);
}

/// A tape is measured along the bone when it is finished; until then its label names the straight length.
TEST(PositionMarking, ATapeShowsAStraightLength) {
  PositionMarking marking;
  Marked marked;
  marking.begin({"Tape", 2, 9, Request::Quantity::straight}, into(marked));
  for (const dvec3& at : {dvec3(0), dvec3(3, 0, 0)}) marking.add(at);
  EXPECT_EQ(label(marking, dvec3(3, 4, 0)), "straight 7.0 mm");
}

TEST(PositionMarking, AnAngleIsThatAtItsSecondPosition) {
  PositionMarking marking;
  Marked marked;
  marking.begin({"Angle", 3, 3, Request::Quantity::angle}, into(marked));
  marking.add({10, 0, 0});
  EXPECT_EQ(label(marking, dvec3(0)), "");
  marking.add({0, 0, 0});
  EXPECT_EQ(label(marking, dvec3(0, 0, 2)), "90.0\u00b0");
  EXPECT_EQ(label(marking, dvec3(-5, 0, 0)), "180.0\u00b0");
}

TEST(PositionMarking, IsCancelled) {
  PositionMarking marking;
  Marked marked;
  marking.begin({"Ruler", 2, 2}, into(marked));
  marking.add({1, 0, 0});
  marking.remove_last();
  EXPECT_TRUE(marking.is_active());
  marking.remove_last();
  EXPECT_FALSE(marking.is_active()) << "there was nothing left to remove";
  marking.begin({"Ruler", 2, 2}, into(marked));
  marking.add({1, 0, 0});
  marking.cancel();
  marking.add({2, 0, 0});
  EXPECT_EQ(marked.count, 0);
}

}  // namespace
}  // namespace trephine::view
