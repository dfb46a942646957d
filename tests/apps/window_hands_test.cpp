// Two hands in a window: each has a device and an instrument of its own.
#include "haptics/device/mapped_device.h"
#include "haptics/device/pose_path.h"
#include "sim/session/session_reader.h"
#include "tests/apps/window_fixture.h"

namespace trephine::view {
namespace {

/// Returns a device that moves from `from` to `to` between 0.3 s and 20 s, with its button pressed.
std::shared_ptr<haptics::Device> pressing_device(const glm::dvec3& from, const glm::dvec3& to) {
  return std::make_shared<haptics::PlaybackDevice>(
      haptics::PosePath::from_samples(
          {{0, {from, {1, 0, 0, 0}, 0}}, {0.3, {from, {1, 0, 0, 0}, 1}}, {20, {to, {1, 0, 0, 0}, 1}}}, "")
          .value());
}

/// A device that stops responding.
class DeviceThatIsLost final : public haptics::Device {
 public:
  Status open() override { return std::nullopt; }
  void close() noexcept override {}
  haptics::DeviceCapabilities capabilities() const override { return {.name = "lost"}; }
  bool read(double, haptics::Pose& pose) noexcept override {
    pose.position_world = {0, 0, 90};
    return !is_lost;
  }
  void write(const haptics::Wrench&) noexcept override {}

  std::atomic<bool> is_lost{false};
};

TEST_F(Window, TheWorkspaceOfADeviceIsShown) {
  options_.device = std::make_shared<haptics::MappedDevice>(std::make_shared<DeviceThatIsLost>(),
                                                            haptics::WorkspaceMap{.scale = 0.3});
  MainWindow window(scene_, options_);
  window.show();
  ASSERT_TRUE(QTest::qWaitForWindowExposed(&window, k_patience));
  ASSERT_TRUE(QTest::qWaitFor([&] { return options_.device->workspace().has_value(); }, k_patience));
  EXPECT_NEAR(options_.device->workspace()->radius, 30, 1e-9);
  Viewport& viewport = window.operation()->viewport();
  const std::size_t before = viewport.overlay_count();
  auto* action = child<QAction>(window, "workspace");
  action->trigger();
  EXPECT_TRUE(QTest::qWaitFor([&] { return viewport.overlay_count() == before + 1; }, k_patience));
  let_run(500);
  save_screenshot(window, "workspace");
  action->trigger();
  EXPECT_TRUE(QTest::qWaitFor([&] { return viewport.overlay_count() == before; }, k_patience));
  window.close();
}

/// The force of a lost device in the left hand stays off until the user turns it on, also if the mouse, whose
/// faults end by themselves, is the right hand.
TEST_F(Window, AFaultOfTheLeftHandIsShownAndStays) {
  auto method = std::make_shared<haptics::SubvoxelProxy>();
  ASSERT_FALSE(method->prepare(*scene_));
  const haptics::ServoHand hand(scene_, method, haptics::TouchState(nullptr));
  options_.start =
      WindowStart{sim::Engine({{hand, drilling::burr({})}, {hand, sim::Instrument()}}, 1e-3, catalogue())};
  options_.recorder = nullptr;
  const auto device = std::make_shared<DeviceThatIsLost>();
  options_.left_device = device;
  MainWindow window(scene_, options_);
  window.show();
  ASSERT_TRUE(QTest::qWaitForWindowExposed(&window, k_patience));
  OperationController& operation = *window.operation();
  ASSERT_TRUE(QTest::qWaitFor([&] { return operation.state().hands[1].tick > 10; }, k_patience));
  operation.reset_faults();  // of a busy machine
  ASSERT_TRUE(QTest::qWaitFor([&] { return operation.fault_text().empty(); }, k_patience));
  device->is_lost = true;
  ASSERT_TRUE(QTest::qWaitFor([&] { return !operation.fault_text().empty(); }, k_patience));
  EXPECT_NE(operation.fault_text().find("does not respond"), std::string::npos) << operation.fault_text();
  EXPECT_NE(operation.fault_text().find("Press F"), std::string::npos) << operation.fault_text();
  device->is_lost = false;
  let_run(1500);
  EXPECT_FALSE(operation.fault_text().empty()) << "the force returned by itself";
  QTest::keyClick(&window, Qt::Key_F);
  EXPECT_TRUE(QTest::qWaitFor([&] { return operation.fault_text().empty(); }, k_patience));
  window.close();
}

/// The right hand drills at the top of the ball. The left hand touches the bottom, takes a burr in the panel
/// and drills, too. The session has both hands.
TEST_F(Window, EachOfTwoHandsDrillsWithItsOwnTool) {
  auto method = std::make_shared<haptics::SubvoxelProxy>();
  ASSERT_FALSE(method->prepare(*scene_));
  const haptics::ServoHand hand(scene_, method, haptics::TouchState(nullptr));
  options_.start =
      WindowStart{sim::Engine({{hand, drilling::burr({})}, {hand, sim::Instrument()}}, 1e-3, catalogue())};
  const std::string file = (folder_ / "two.session").string();
  auto recorder =
      sim::SessionWriter::create(file,
                                 sim::describe_scene(*scene_, haptics::SubvoxelProxy(), {},
                                                     {sim::HandSpec(drilling::burr({})), sim::HandSpec()}),
                                 scene_->base, catalogue())
          .value();
  options_.recorder = recorder.get();
  options_.session_file = file;
  options_.device = pressing_device({0, 0, 46}, {0, 0, 28});
  options_.left_device = pressing_device({0, 0, -46}, {0, 0, -28});
  {
    MainWindow window(scene_, options_);
    window.show();
    ASSERT_TRUE(QTest::qWaitForWindowExposed(&window, k_patience));
    OperationController& operation = *window.operation();
    ASSERT_EQ(operation.hand_count(), 2u);
    ASSERT_TRUE(QTest::qWaitFor([&] { return operation.state().removed_mm3 > 3; }, k_patience));
    EXPECT_TRUE(operation.tool(1).is_empty());
    ASSERT_TRUE(QTest::qWaitFor([&] { return operation.state().hands[1].has_contact; }, k_patience));
    const auto is_cut_below = [&] {
      const auto version = operation.frozen_version();
      for (double z = -46; z < -20; z += 0.25)
        if (!version->is_kept(volume::voxel_of(scene_->base->frame.volume_from_world({0, 0, z}))))
          return true;
      return false;
    };
    EXPECT_FALSE(is_cut_below());
    auto* hands = child<QComboBox>(window, "tool_hand");
    auto* instrument = child<QComboBox>(window, "instrument");
    EXPECT_GE(instrument->currentIndex(), 0) << "the right hand holds a burr";
    hands->setCurrentIndex(1);
    EXPECT_EQ(instrument->currentIndex(), -1) << "the left hand holds no tool";
    emit instrument->activated(0);
    ASSERT_TRUE(QTest::qWaitFor([&] { return !operation.tool(1).is_empty(); }, k_patience));
    EXPECT_EQ(operation.tool(0), sim::Value(drilling::Burr{}));
    ASSERT_TRUE(QTest::qWaitFor(is_cut_below, k_patience));
    let_run(200);
    save_screenshot(window, "two-hands");
    hands->setCurrentIndex(0);
    EXPECT_GE(instrument->currentIndex(), 0);
    window.close();
  }
  const auto session = sim::SessionReader::open(file, catalogue());
  ASSERT_TRUE(session) << session.error().message();
  EXPECT_EQ(session.value().header().hands.size(), 2u);
}

}  // namespace
}  // namespace trephine::view
