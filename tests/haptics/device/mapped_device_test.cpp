// MappedDevice, CompositeDevice, SpaceMouse and Latest.
#include "haptics/device/mapped_device.h"

#include <cmath>
#include <glm/geometric.hpp>
#include <gtest/gtest.h>
#include <limits>
#include <numbers>
#include <thread>

#include "haptics/device/composite_device.h"
#include "haptics/device/latest.h"
#include "haptics/device/spacemouse.h"

using namespace trephine;
using namespace trephine::haptics;
using glm::dvec3;

namespace {

/// A device whose pose is set by a test. It keeps the wrench that was written last.
struct HandDevice final : Device {
  Pose pose;
  Wrench written;
  bool responds = true, is_open = false;
  Status open() override {
    is_open = true;
    return std::nullopt;
  }
  void close() noexcept override { is_open = false; }
  DeviceCapabilities capabilities() const override { return {"hand", 6, 8, 2, 50, 0, 0.1, 0.004}; }
  bool read(double, Pose& out) noexcept override {
    if (responds) out = pose;
    return responds;
  }
  void write(const Wrench& wrench) noexcept override { written = wrench; }
};

/// Returns a quarter turn about z: the device's x is the world's y.
glm::dquat quarter() { return glm::angleAxis(std::numbers::pi / 2, dvec3(0, 0, 1)); }

/// A device that the servo pushes with 4 N.
struct PushedDevice {
  std::shared_ptr<HandDevice> hand = std::make_shared<HandDevice>();
  std::unique_ptr<MappedDevice> device = std::make_unique<MappedDevice>(hand, WorkspaceMap());
  PushedDevice() {
    device->set_view({});
    EXPECT_FALSE(device->open());
  }
  /// Reads and writes at a time. Returns the force that the device received, N.
  double force_at(double t) const {
    Pose pose;
    device->read(t, pose);
    device->write(Wrench(dvec3(0, 0, 4)));
    return hand->written.force_world.z;
  }
};

void expect_near(const dvec3& a, const dvec3& b, double tolerance = 1e-12) {
  EXPECT_LT(glm::length(a - b), tolerance)
      << a.x << " " << a.y << " " << a.z << ", expected " << b.x << " " << b.y << " " << b.z;
}

}  // namespace

TEST(MappedDevice, MapsPositionsAndForces) {
  const auto hand = std::make_shared<HandDevice>();
  MappedDevice device(hand, {.scale = 2});
  device.set_view({dvec3(10, 20, 30), quarter()});
  ASSERT_FALSE(device.open());
  hand->pose.position_world = {1, 0, 0};
  Pose pose;
  ASSERT_TRUE(device.read(0, pose));
  expect_near(pose.position_world, {10, 22, 30});
  device.write(Wrench(dvec3(0, 3, 0), dvec3(1, 0, 0)));
  expect_near(hand->written.force_world, {3, 0, 0});
  expect_near(hand->written.torque_world, {0, -1, 0});
  // The tool moves twice as far as the device under the same force: half the stiffness.
  EXPECT_EQ(device.capabilities().max_stiffness, 1);
  EXPECT_EQ(device.capabilities().workspace_radius, 100);
}

TEST(MappedDevice, TheToolStaysInPlaceWhenTheViewTurns) {
  const auto hand = std::make_shared<HandDevice>();
  MappedDevice device(hand, {});
  device.set_view({dvec3(0), {1, 0, 0, 0}});
  Pose pose;
  hand->pose.position_world = {5, 0, 0};
  ASSERT_TRUE(device.read(0, pose));
  device.set_view({dvec3(99), quarter()});
  ASSERT_TRUE(device.read(0.001, pose));
  expect_near(pose.position_world, {5, 0, 0});
  hand->pose.position_world = {6, 0, 0};
  ASSERT_TRUE(device.read(0.002, pose));
  expect_near(pose.position_world, {5, 1, 0});
}

/// While the device does not respond it has no force; afterwards the force returns gradually.
TEST(MappedDevice, TheForceReturnsGraduallyAfterADropout) {
  const PushedDevice pushed;
  const auto& hand = pushed.hand;
  EXPECT_EQ(pushed.force_at(0), 4);
  hand->responds = false;
  EXPECT_EQ(pushed.force_at(0.1), 0);
  hand->responds = true;
  EXPECT_EQ(pushed.force_at(0.2), 0);
  EXPECT_NEAR(pushed.force_at(0.225), 1, 1e-12);
  EXPECT_NEAR(pushed.force_at(0.3), 4, 1e-12);
  EXPECT_EQ(pushed.force_at(0.4), 4);
}

/// The force does not wait for the former time.
TEST(MappedDevice, AClockThatBeginsAgainDoesNotWithholdTheForce) {
  const PushedDevice pushed;
  const auto& hand = pushed.hand;
  hand->responds = false;
  EXPECT_EQ(pushed.force_at(100), 0);
  hand->responds = true;
  EXPECT_EQ(pushed.force_at(100.1), 0);
  EXPECT_EQ(pushed.force_at(101), 4);
  EXPECT_EQ(pushed.force_at(0), 0) << "it begins from zero";
  EXPECT_NEAR(pushed.force_at(0.05), 2, 1e-12);
  EXPECT_EQ(pushed.force_at(0.2), 4);
}

TEST(MappedDevice, APoseThatIsNotFiniteIsNoPose) {
  const auto hand = std::make_shared<HandDevice>();
  MappedDevice device(hand, {});
  device.set_view({dvec3(1, 2, 3), {1, 0, 0, 0}});
  ASSERT_FALSE(device.open());
  Pose pose;
  ASSERT_TRUE(device.read(0, pose));
  for (const double bad : {std::nan(""), 1e300, -std::numeric_limits<double>::infinity()}) {
    hand->pose.position_world = {0, bad, 0};
    EXPECT_FALSE(device.read(0.1, pose));
    device.write(Wrench(dvec3(0, 0, 4)));
    EXPECT_TRUE(hand->written.is_zero());
    device.set_view({dvec3(1, 2, 3), quarter()});  // the tool stays in place, at its last valid position
    hand->pose.position_world = {};
    ASSERT_TRUE(device.read(0.2, pose));
    expect_near(pose.position_world, {1, 2, 3});
    device.set_view({dvec3(1, 2, 3), {1, 0, 0, 0}});
    ASSERT_TRUE(device.read(0.3, pose));
  }
  hand->pose.orientation = {std::nan(""), 0, 0, 0};
  EXPECT_FALSE(device.read(0.4, pose));
  hand->pose.orientation = {1, 0, 0, 0};
  EXPECT_FALSE(device.read(std::nan(""), pose)) << "a time that is not a number";
  device.write(Wrench(dvec3(0, 0, 4)));
  EXPECT_TRUE(std::isfinite(hand->written.force_world.z));
}

/// The workspace lies around the tool, and moves with the clutch.
TEST(MappedDevice, ReportsTheWorkspaceInTheWorld) {
  const auto hand = std::make_shared<HandDevice>();
  MappedDevice device(hand, {.scale = 2});
  device.set_view({dvec3(10, 20, 30), quarter()});
  EXPECT_FALSE(device.workspace());
  ASSERT_FALSE(device.open());
  Pose pose;
  hand->pose.position_world = {5, 0, 0};
  ASSERT_TRUE(device.read(0, pose));
  ASSERT_TRUE(device.workspace());
  expect_near(device.workspace()->centre_world, {10, 20, 30});
  EXPECT_EQ(device.workspace()->radius, 100);
  hand->pose.position_world = {50, 0, 0};
  ASSERT_TRUE(device.read(0.001, pose));
  expect_near(device.workspace()->centre_world, {10, 20, 30});
  expect_near(pose.position_world, {10, 120, 30});
  hand->pose.buttons = 2;
  ASSERT_TRUE(device.read(0.002, pose));
  hand->pose.position_world = {0, 0, 0};
  ASSERT_TRUE(device.read(0.003, pose));
  hand->pose.buttons = 0;
  ASSERT_TRUE(device.read(0.004, pose));
  expect_near(device.workspace()->centre_world, {10, 120, 30});
}

TEST(MappedDevice, TheClutchMovesTheHandWithoutTheTool) {
  const auto hand = std::make_shared<HandDevice>();
  MappedDevice device(hand, {.resume_seconds = 0.1});
  device.set_view({});
  Pose pose;
  hand->pose.position_world = {1, 2, 3};
  hand->pose.buttons = 1;
  ASSERT_TRUE(device.read(0, pose));
  EXPECT_TRUE(pose.is_pressed());
  device.write(Wrench(dvec3(0, 0, 4)));
  expect_near(hand->written.force_world, {0, 0, 4});
  hand->pose.buttons = 3;  // the first button, and the clutch
  for (int i = 1; i <= 100; ++i) {
    hand->pose.position_world.x += 0.4;
    ASSERT_TRUE(device.read(0.001 * i, pose));
    expect_near(pose.position_world, {1, 2, 3});
    EXPECT_FALSE(pose.is_pressed());
    EXPECT_EQ(pose.buttons & 2u, 0u);
    device.write(Wrench(dvec3(0, 0, 4)));
    ASSERT_TRUE(hand->written.is_zero());
  }
  hand->pose.buttons = 0;
  double last = 0;
  for (int i = 101; i <= 260; ++i) {
    ASSERT_TRUE(device.read(0.001 * i, pose));
    expect_near(pose.position_world, {1, 2, 3});
    device.write(Wrench(dvec3(0, 0, 4)));
    const double force = hand->written.force_world.z;
    EXPECT_GE(force, last);
    EXPECT_LT(force - last, 0.05);  // the force returns without a jump
    last = force;
  }
  EXPECT_EQ(last, 4);
  hand->pose.position_world.x += 1;
  ASSERT_TRUE(device.read(0.3, pose));
  expect_near(pose.position_world, {2, 2, 3});
}

/// The tool starts where the view places it, even if the clutch is pressed from the first pose on.
TEST(MappedDevice, AClutchThatIsPressedAtTheStartDoesNotMoveTheTool) {
  const auto hand = std::make_shared<HandDevice>();
  MappedDevice device(hand, {});
  Pose pose;
  for (const dvec3& start : {dvec3(100, 200, 300), dvec3(-50, 0, 0)}) {
    device.set_view({start, quarter()});
    ASSERT_FALSE(device.open());
    hand->pose.buttons = 2;
    hand->pose.position_world = {0, 0, 0};
    ASSERT_TRUE(device.read(0, pose));
    expect_near(pose.position_world, start);
    hand->pose.position_world = {7, 0, 0};
    ASSERT_TRUE(device.read(0.1, pose));
    hand->pose.buttons = 0;
    ASSERT_TRUE(device.read(0.2, pose));
    expect_near(pose.position_world, start);
    device.close();
  }
}

TEST(MappedDevice, AnImpossibleScaleIsRefused) {
  EXPECT_TRUE(MappedDevice(std::make_shared<HandDevice>(), {.scale = 0}).open());
  EXPECT_TRUE(MappedDevice(std::make_shared<HandDevice>(), {.scale = std::nan("")}).open());
}

TEST(CompositeDevice, APedalWorksTheToolOfAnotherDevice) {
  const auto hand = std::make_shared<HandDevice>(), pedal = std::make_shared<HandDevice>();
  CompositeDevice device(hand, pedal);
  ASSERT_FALSE(device.open());
  EXPECT_TRUE(hand->is_open && pedal->is_open);
  hand->pose.buttons = 4, pedal->pose.buttons = 0, pedal->pose.position_world = {9, 9, 9};
  pedal->pose.axes = {0.5f, 0, 0, 0};
  Pose pose;
  ASSERT_TRUE(device.read(0, pose));
  EXPECT_FALSE(pose.is_pressed());
  expect_near(pose.position_world, dvec3(0));
  pedal->pose.buttons = 1;
  ASSERT_TRUE(device.read(0, pose));
  EXPECT_EQ(pose.buttons, 5u);
  EXPECT_EQ(pose.axes[0], 0.5f);
  device.write(Wrench(dvec3(1, 0, 0)));
  expect_near(hand->written.force_world, {1, 0, 0});
  EXPECT_TRUE(pedal->written.is_zero());
  pedal->responds = false;  // unplugged while pressed
  EXPECT_FALSE(device.read(0, pose));
}

TEST(SpaceMouse, BothFormatsOfReportsAreRead) {
  SpaceMouseParser parser;
  // The report: 256 to the right, 2 toward the user, 3 down. The device frame: right, up, toward the user.
  const std::uint8_t motion[] = {1, 0, 1, 2, 0, 3, 0};
  const std::uint8_t turn[] = {2, 0xff, 0xff, 0, 0x80, 5, 0};
  ASSERT_TRUE(parser.add(motion));
  ASSERT_TRUE(parser.add(turn));
  EXPECT_EQ(parser.state().motion, (std::array<std::int16_t, 3>{256, -3, 2}));
  EXPECT_EQ(parser.state().turn, (std::array<std::int16_t, 3>{-1, -5, -32768}));
  const std::uint8_t both[] = {1, 1, 0, 2, 0, 3, 0, 4, 0, 5, 0, 6, 0};
  ASSERT_TRUE(parser.add(both));
  EXPECT_EQ(parser.state().motion, (std::array<std::int16_t, 3>{1, -3, 2}));
  EXPECT_EQ(parser.state().turn, (std::array<std::int16_t, 3>{4, -6, 5}));
  const std::uint8_t buttons[] = {3, 2, 0x80};
  ASSERT_TRUE(parser.add(buttons));
  EXPECT_EQ(parser.state().buttons, 0x8002u);
  EXPECT_FALSE(parser.add(std::span(motion).first(5)));
  EXPECT_FALSE(parser.add({}));
  const std::uint8_t battery[] = {0x17, 90};
  EXPECT_FALSE(parser.add(battery));
  EXPECT_EQ(parser.state().buttons, 0x8002u);
}

TEST(SpaceMouse, DeflectionMovesTheToolAtARate) {
  const RateControl control{.speed = 60, .radius = 30, .dead_zone = 0};
  RatePose pose(control);
  SpaceMouseState state;
  state.motion = {350, 0, 0};
  for (int i = 0; i < 100; ++i) pose.move(state, 0.001);
  expect_near(pose.position(), {6, 0, 0}, 1e-9);
  state.motion = {-175, 0, 0};  // half the deflection, a quarter of the speed
  for (int i = 0; i < 100; ++i) pose.move(state, 0.001);
  expect_near(pose.position(), {4.5, 0, 0}, 1e-9);
  pose.move(state, 1e9);  // a stall counts as 0.1 s
  expect_near(pose.position(), {3, 0, 0}, 1e-9);
  state.motion = {32767, 32767, 32767};
  for (int i = 0; i < 5000; ++i) pose.move(state, 0.001);
  EXPECT_NEAR(glm::length(pose.position()), 30, 1e-9);
  state.motion = {};
  state.turn = {0, 350, 0};
  for (int i = 0; i < 1000; ++i) pose.move(state, 0.001);
  EXPECT_NEAR(2 * std::atan2(pose.orientation().y, pose.orientation().w), control.turning, 1e-3);
}

TEST(Latest, AReaderNeverSeesHalfAValue) {
  struct Pair {
    std::uint64_t a = 0, b = 0, c = 0;
  };
  Latest<Pair> latest;
  std::atomic<bool> is_done{false};
  std::uint64_t written = 0;
  std::thread writer([&] {
    while (!is_done || written < 1000) ++written, latest.set({written, 2 * written, 3 * written});
  });
  std::uint64_t last = 0, count = 0;
  bool is_whole = true;
  while (count < 20'000) {
    const auto value = latest.get();
    if (!value) continue;
    ++count;
    is_whole = is_whole && value->b == 2 * value->a && value->c == 3 * value->a && value->a >= last;
    last = value->a;
  }
  is_done = true;
  writer.join();
  EXPECT_TRUE(is_whole);
  EXPECT_EQ(latest.get()->a, written);
}
