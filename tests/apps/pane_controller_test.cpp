// PaneController: X-rays of a replay, and slices that follow the tool.
#include "apps/view/pane_controller.h"

#include <gtest/gtest.h>

#include "apps/bench/scenes/scenes.h"
#include "modules/fluoroscopy/fluoroscopy.h"
#include "tests/apps/window_fixture.h"

namespace trephine::view {
namespace {

/// Returns the input of a frame of an uncut scene.
PaneInput input_of(const haptics::TouchScene& scene, const haptics::ServoRecord& record) {
  return {.scene = scene,
          .version = std::make_shared<volume::Version>(scene.base),
          .plan = nullptr,
          .settings = {},
          .forbidden = {},
          .newest = record,
          .camera = {},
          .clip = {}};
}

/// A replay that goes back has no X-ray of a later moment, and takes it again when the moment comes.
TEST(PaneController, AReplayThatGoesBackHasNoLaterXray) {
  const haptics::TouchScene scene = scenes::phantom_scene("sphere", {});
  const haptics::ServoRecord record;
  PaneController panes(1);
  panes.begin();
  panes.panes().set_kind(0, imaging::PaneKind::xray);
  panes.panes().set_size(0, 64, 64, true);
  // Shows the state with a number of shots. Returns true if there is an image within `ms`.
  const auto has_image = [&](std::int64_t shots, int ms) {
    fluoroscopy::FluoroscopyState state;
    state.shots = shots, state.seconds = 0.1 * static_cast<double>(shots);
    const std::vector<std::shared_ptr<const sim::Value>> settings{
        std::make_shared<const sim::Value>(std::move(state))};
    PaneInput input = input_of(scene, record);
    input.settings = settings;
    return QTest::qWaitFor([&] { return panes.frame(input), panes.panes().panel(0) != nullptr; }, ms);
  };
  EXPECT_FALSE(has_image(0, 300)) << "no X-ray was taken";
  EXPECT_TRUE(has_image(1, k_patience));
  EXPECT_FALSE(panes.panes().xray_note().empty());
  EXPECT_FALSE(has_image(0, 300));
  EXPECT_TRUE(panes.panes().xray_note().empty());
  EXPECT_TRUE(has_image(1, k_patience));
}

/// After a jump in a replay, the slices do not depend on what was shown before.
TEST(PaneController, SlicesShowTheToolAfterAJumpInAReplay) {
  const haptics::TouchScene scene = scenes::phantom_scene("sphere", {});
  haptics::ServoRecord record;
  PaneController panes(3);
  panes.begin();
  const auto focus_at = [&](double t, const glm::dvec3& tool) {
    record.t = t, record.pose.position_world = tool;
    panes.frame(input_of(scene, record));
    return panes.panes().focus();
  };
  const glm::dvec3 tool(1, 2, 3);
  EXPECT_NE(focus_at(0.1, tool), tool) << "it touches nothing";
  EXPECT_EQ(focus_at(10, tool), tool);
  EXPECT_EQ(focus_at(10.1, {4, 5, 6}), tool) << "no jump";
  EXPECT_EQ(focus_at(3, {7, 8, 9}), glm::dvec3(7, 8, 9));
  panes.apply = [](const sim::Value&) {};
  EXPECT_EQ(focus_at(20, tool), glm::dvec3(7, 8, 9)) << "an operation has no jumps";
}

/// A probe in its track touches nothing, but the slices follow its tip.
TEST(PaneController, FollowsAnInsertedTool) {
  const haptics::TouchScene scene = scenes::phantom_scene("sphere", {});
  haptics::ServoRecord record;
  record.pose.position_world = {1, 2, 3};
  PaneController panes(3);
  panes.begin();
  const auto focus_of = [&](bool is_inserted) {
    PaneInput input = input_of(scene, record);
    input.is_inserted = is_inserted;
    panes.frame(input);
    return panes.panes().focus();
  };
  EXPECT_NE(focus_of(false), record.pose.position_world);
  EXPECT_EQ(focus_of(true), record.pose.position_world);
  record.pose.position_world = {4, 5, 6};
  EXPECT_EQ(focus_of(true), record.pose.position_world);
  EXPECT_EQ(focus_of(false), record.pose.position_world) << "it stays where the tool was";
}

}  // namespace
}  // namespace trephine::view
