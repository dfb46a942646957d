// LineGuide: a mouse inserts a tool along a planned trajectory, or along the shaft of the tool.
#include "apps/view/line_guide.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <gtest/gtest.h>
#include <optional>
#include <vector>

namespace trephine::view {
namespace {

using glm::dvec3;

/// A cursor over a surface at z = 0, seen from above. The tip follows the hand, but not deeper than
/// `deepest`.
struct InsertionDesk {
  LineGuide guide = {};
  LineGuide::Input input = {};
  std::vector<LineGuide::Line> planned = {{{0, 0, 0}, {10, 0, -40}}};
  double most_lead = 0;  ///< largest distance of the hand beyond `deepest`, mm
  double deepest = 100;  ///< mm along the line to which the matter lets the tip pass

  explicit InsertionDesk(double x) {
    input.length = 60;
    look_at(x);
  }
  void look_at(double x) { input.ray_origin = {x, 0, 100}, input.surface = dvec3(x, 0, 0); }
  std::optional<LineGuide::Pose> frames(int count) {
    std::optional<LineGuide::Pose> pose;
    for (int i = 0; i < count; ++i) {
      input.seconds = 1.0 / 60;
      pose = guide.follow(planned, input);
      if (!pose) continue;
      const dvec3 ahead = -pose->shaft;
      const double hand = glm::dot(pose->at_world - dvec3(0), ahead);
      most_lead = std::max(most_lead, hand - deepest);
      input.tip = pose->at_world - std::max(0.0, hand - deepest) * ahead;
    }
    return pose;
  }
};

TEST(LineGuide, AWithdrawnToolLeavesItsTrack) {
  InsertionDesk desk(3);
  desk.frames(1);
  desk.input.is_pressed = true;
  desk.frames(120);
  EXPECT_GT(desk.guide.inserted_depth(), 10);
  desk.input.is_pressed = false;
  desk.frames(2);
  desk.guide.withdraw();
  desk.frames(60);
  EXPECT_EQ(desk.guide.inserted_depth(), 0);
}

TEST(LineGuide, StandsOnAPlannedTrajectoryAndFollowsIt) {
  InsertionDesk desk(3);
  const dvec3 ahead = glm::normalize(dvec3(10, 0, -40));
  const auto standing = desk.frames(1);
  ASSERT_TRUE(standing);
  EXPECT_TRUE(standing->is_jump);
  EXPECT_FALSE(standing->is_pressed);
  EXPECT_LT(glm::length(standing->shaft + ahead), 1e-9);
  EXPECT_LT(glm::dot(standing->at_world, ahead), -5) << "above the bone";
  EXPECT_EQ(desk.guide.line().size(), 2u);
  EXPECT_FALSE(desk.frames(1)->is_jump);
  desk.input.is_pressed = true;
  const auto pushed = desk.frames(180);  // 3 s at 10 mm/s
  EXPECT_TRUE(pushed->is_pressed);
  EXPECT_NEAR(desk.guide.depth(), 22, 1);
  EXPECT_LT(glm::length(glm::cross(pushed->at_world, ahead)), 1e-9) << "on the line";
  // The wheel moves the tool, too. The length of the tool limits the depth.
  desk.input.is_pressed = false;
  desk.frames(1);
  EXPECT_TRUE(desk.guide.advance(-5));
  desk.frames(1);
  EXPECT_NEAR(desk.guide.depth(), 17, 1);
  desk.input.is_pressed = true;
  desk.frames(600);
  EXPECT_NEAR(desk.guide.depth(), 60, 1e-9);
}

TEST(LineGuide, PushesNoHarderThanAHandAndStopsWithTheButton) {
  InsertionDesk desk(0);
  desk.deepest = 12;
  desk.frames(1);
  desk.input.is_pressed = true;
  desk.frames(600);
  EXPECT_NEAR(desk.most_lead, 8, 0.2);
  // A drill whose clutch has released is not pushed, although the button is down.
  desk.input.has_stopped = true;
  desk.frames(60);
  EXPECT_NEAR(desk.guide.depth(), 12, 1e-6) << "stopped";
  desk.input.has_stopped = false;
  desk.frames(60);
  EXPECT_GT(desk.guide.depth(), 15);
  desk.input.is_pressed = false;
  desk.frames(1);
  EXPECT_NEAR(desk.guide.depth(), 12, 1e-6) << "without pressure";
  desk.frames(60);
  EXPECT_NEAR(desk.guide.depth(), 12, 1e-6) << "stays in its track";
}

TEST(LineGuide, IsWithdrawnAlongItsLineByAClickElsewhere) {
  InsertionDesk desk(0);
  desk.frames(1);
  desk.input.is_pressed = true;
  desk.frames(240);
  desk.input.is_pressed = false;
  desk.look_at(30);
  desk.frames(30);
  EXPECT_NEAR(desk.guide.depth(), 32, 1) << "stays for an X-ray";
  desk.input.is_pressed = true;
  desk.frames(1);
  desk.input.is_pressed = false;
  const dvec3 ahead = glm::normalize(dvec3(10, 0, -40));
  bool is_on_line = true;
  int frames = 0;
  for (auto pose = desk.frames(1); pose; pose = desk.frames(1), ++frames) {
    ASSERT_LT(frames, 100);
    is_on_line &= glm::length(glm::cross(pose->at_world, ahead)) < 1e-9 && !pose->is_jump;
  }
  EXPECT_TRUE(is_on_line);
  EXPECT_GT(frames, 10);
  EXPECT_FALSE(desk.guide.is_holding());
  EXPECT_LT(glm::dot(desk.input.tip, ahead), -5) << "out of the bone";
}

TEST(LineGuide, AnotherToolIsNotInTheTrackOfTheLastOne) {
  InsertionDesk desk(0);
  desk.frames(1);
  desk.input.is_pressed = true;
  desk.frames(240);
  desk.input.is_pressed = false;
  desk.input.length = 150;
  const auto pose = desk.frames(1);
  EXPECT_FALSE(desk.guide.is_holding());
  ASSERT_TRUE(pose);
  EXPECT_TRUE(pose->is_jump);
  EXPECT_LT(desk.guide.depth(), 0) << "above the bone";
}

TEST(LineGuide, AwayFromTrajectoriesTheShaftGivesTheLine) {
  InsertionDesk desk(25);
  EXPECT_FALSE(desk.frames(5)) << "follows the cursor";
  EXPECT_TRUE(desk.guide.line().empty());
  desk.input.shaft = glm::normalize(dvec3(1, 0, 2));
  desk.input.is_pressed = true;
  const auto pose = desk.frames(100);
  ASSERT_TRUE(pose);
  EXPECT_LT(glm::length(glm::cross(pose->at_world - dvec3(25, 0, 0), desk.input.shaft)), 1e-9);
  // A drill follows planned trajectories only.
  InsertionDesk drill(25);
  drill.input.is_drill = drill.input.is_pressed = true;
  EXPECT_FALSE(drill.frames(5));
  drill.input.is_pressed = false;
  drill.look_at(2);
  EXPECT_TRUE(drill.frames(1));
  // A tool without a length to insert is not guided. A tool is not guided to an entry behind bone.
  desk.input.length = 0;
  EXPECT_FALSE(desk.frames(1));
  InsertionDesk hidden(2);
  hidden.input.surface = dvec3(2, 0, 40);
  EXPECT_FALSE(hidden.frames(1));
  EXPECT_FALSE(hidden.guide.advance(1));
}

}  // namespace
}  // namespace trephine::view
