// TouchDevice and ForceDimensionDevice against stand-ins for the vendors' libraries.
#include <cmath>
#include <dlfcn.h>
#include <glm/geometric.hpp>
#include <gtest/gtest.h>

#include "haptics/hardware/force_dimension_device.h"
#include "haptics/hardware/touch_device.h"
#include "tests/haptics/hardware/fake_vendor.h"
#include "tests/haptics/hardware/waiting.h"

using namespace trephine;
using namespace trephine::haptics;
using glm::dvec3;

namespace {

/// Loads a stand-in, resets its faults and values, and returns its state.
fake_vendor::State& state_of(const char* library, const char* symbol) {
  void* const loaded = ::dlopen(library, RTLD_NOW | RTLD_LOCAL);
  auto* const state = static_cast<fake_vendor::State*>(loaded ? ::dlsym(loaded, symbol) : nullptr);
  if (!state) throw std::runtime_error("the stand-in was not built");
  for (auto* const fault :
       {&state->has_no_device, &state->refuses_to_open, &state->fails, &state->needs_inkwell,
        &state->is_silent, &state->has_hot_motors, &state->needs_update})
    *fault = false;
  for (auto& value : state->position) value = 0;
  for (int i = 0; i < 9; ++i) state->rotation[i] = i % 4 == 0;
  state->calibration_styles = 4, state->calibrated_by = 0;
  state->buttons = 0, state->frames = 0, state->frames_with_force = 0;
  return *state;
}
fake_vendor::State& touch_state() { return state_of(TREPHINE_FAKE_HD, "fake_hd"); }
fake_vendor::State& dhd_state() { return state_of(TREPHINE_FAKE_DHD, "fake_dhd"); }

TouchChoice touch_choice() {
  TouchChoice choice;
  choice.files = {"libnone_of_this_name.so", TREPHINE_FAKE_HD};
  choice.calibration_seconds = 0.1;
  return choice;
}
ForceDimensionChoice dhd_choice() { return {0, {TREPHINE_FAKE_DHD}}; }

void set(std::atomic<double>* values, std::initializer_list<double> numbers) {
  for (const double number : numbers) *values++ = number;
}

dvec3 wrench_part(const fake_vendor::State& state, int first) {
  return {state.wrench[first].load(), state.wrench[first + 1].load(), state.wrench[first + 2].load()};
}

/// Writes a wrench until the library receives the expected force. Returns false if it never does.
bool renders(Device& device, fake_vendor::State& state, const Wrench& wrench, const dvec3& expected) {
  return eventually([&] {
    device.write(wrench);
    return glm::length(wrench_part(state, 0) - expected) < 1e-12;
  });
}

/// Expects a pose in the frame of MappedDevice: x to the right, y up, z toward the user.
void expect_pose(Device& device, const dvec3& position, const dvec3& tool_axis, std::uint32_t buttons) {
  Pose pose;
  EXPECT_TRUE(eventually([&] {
    return device.read(0, pose) && glm::length(pose.position_world - position) < 1e-9 &&
           glm::length(pose.orientation * dvec3(0, 0, 1) - tool_axis) < 1e-9 && pose.buttons == buttons;
  })) << pose.position_world.x
      << " " << pose.position_world.y << " " << pose.position_world.z;
}

/// Checks a device: no force before the servo writes one, none when it stalls, none after closing.
void expect_safe_force(Device& device, fake_vendor::State& state) {
  state.frames_with_force = 0;
  ASSERT_FALSE(device.open());
  const int first = state.frames;
  ASSERT_TRUE(eventually([&] { return state.frames > first + 5; }));
  EXPECT_EQ(state.frames_with_force, 0);
  EXPECT_TRUE(eventually([&] {
    device.write(Wrench(dvec3(0, 0, 2)));
    return state.frames_with_force > 0;
  }));
  EXPECT_TRUE(eventually([&] { return wrench_part(state, 0) == dvec3(0); }));  // no write: the servo stalls
  EXPECT_TRUE(eventually([&] {
    device.write(Wrench(dvec3(0, 0, 2)));
    return wrench_part(state, 0) != dvec3(0);
  }));
  device.close();
  EXPECT_EQ(wrench_part(state, 0), dvec3(0));
  EXPECT_FALSE(state.has_force);
  EXPECT_FALSE(state.is_open);
}

/// Expects that a device is lost while its library does not answer, and available again afterwards.
void expect_loss_and_return(Device& device, std::atomic<bool>& fault) {
  Pose pose;
  ASSERT_FALSE(device.open());
  double t = 0;
  ASSERT_TRUE(eventually([&] { return device.read(t, pose); }));
  fault = true;
  EXPECT_TRUE(eventually([&] { return !device.read(t += 0.11, pose); }));
  fault = false;
  EXPECT_TRUE(eventually([&] { return device.read(t, pose); }));
  device.close();
}

}  // namespace

TEST(TouchDevice, PosesAreThoseOfTheLibraryAboutTheCentreOfItsWorkspace) {
  auto& state = touch_state();
  TouchDevice device(touch_choice());
  const Status error = device.open();
  ASSERT_FALSE(error) << error->message();
  EXPECT_TRUE(state.has_force);
  const DeviceCapabilities c = device.capabilities();
  EXPECT_EQ(c.name, "3D Systems Touch");
  EXPECT_EQ(c.degrees_of_freedom, 6);
  EXPECT_EQ(c.max_force, 3.3);
  EXPECT_EQ(c.max_stiffness, 1.02);
  EXPECT_EQ(c.workspace_radius, 40);
  set(state.position, {10, -20, 15});
  set(state.rotation, {1, 0, 0, 0, 0, -1, 0, 1, 0});  // about x by 90 degrees: z turns to -y
  state.buttons = 2;
  expect_pose(device, {10, -20, 10}, {0, -1, 0}, 2);
  EXPECT_TRUE(renders(device, state, Wrench({1, -2, 0.5}, {9, 9, 9}), {1, -2, 0.5}));
  device.close();
  EXPECT_FALSE(state.is_running);
}

TEST(TouchDevice, ForceIsZeroUntilWrittenWhenStalledAndAfterClosing) {
  auto& state = touch_state();
  TouchDevice device(touch_choice());
  expect_safe_force(device, state);
  expect_safe_force(device, state);  // opened again
}

TEST(TouchDevice, HotMotorsPauseTheForceAndErrorsOfCommunicationLoseTheDevice) {
  auto& state = touch_state();
  TouchDevice device(touch_choice());
  ASSERT_FALSE(device.open());
  const Wrench wrench(dvec3(0, 1, 0));
  ASSERT_TRUE(renders(device, state, wrench, {0, 1, 0}));
  state.has_hot_motors = true;
  EXPECT_TRUE(renders(device, state, wrench, {0, 0, 0}));
  Pose pose;
  EXPECT_TRUE(device.read(0, pose));  // poses are still reported
  state.has_hot_motors = false;
  EXPECT_TRUE(renders(device, state, wrench, {0, 1, 0}));
  device.close();
  expect_loss_and_return(device, state.fails);
  expect_loss_and_return(device, state.is_silent);  // a scheduler that hangs
}

TEST(TouchDevice, IsCalibratedByOneOfItsStyles) {
  // Bits of libHD: 1 encoder reset, 2 automatic, 4 inkwell.
  for (const auto& [styles, chosen] : {std::pair(7, 2), {6, 2}, {3, 2}, {1, 1}}) {
    auto& state = touch_state();
    state.calibration_styles = styles, state.needs_update = true;
    TouchDevice device(touch_choice());
    EXPECT_FALSE(device.open());
    EXPECT_EQ(state.calibrated_by, chosen) << styles;
  }
  // If a device is calibrated at its reset position, the user gets an instruction and time to follow it.
  auto& state = touch_state();
  state.calibration_styles = 1, state.needs_inkwell = true;
  TouchChoice choice = touch_choice();
  choice.calibration_seconds = 60, choice.reset_seconds = 0.1;
  std::vector<std::string> notices;
  choice.notice = [&](const std::string& text) { notices.push_back(text); };
  TouchDevice device(choice);
  EXPECT_FALSE(device.open());
  ASSERT_EQ(notices.size(), 1u);
  EXPECT_NE(notices[0].find("reset position"), std::string::npos);
  EXPECT_EQ(state.calibrated_by, 1);

  device.close();
  state.calibration_styles = 2, state.needs_inkwell = true;
  choice.should_stop = [] { return true; };
  TouchDevice stopped(choice);
  const Status error = stopped.open();
  ASSERT_TRUE(error);
  EXPECT_EQ(error->where, "touch: cancelled");
}

TEST(DeviceExchange, ForceExpiresWithTheAgeOfItsWrite) {
  DeviceExchange exchange;
  exchange.restart();
  EXPECT_TRUE(exchange.wrench().is_zero());
  exchange.write(Wrench(dvec3(0, 0, 8)));
  wait_ms(100);  // the driver hangs and reads the force late
  EXPECT_TRUE(exchange.wrench().is_zero());
  EXPECT_TRUE(eventually([&] {
    exchange.write(Wrench(dvec3(0, 0, 8)));
    return exchange.wrench().force_world.z == 8;
  }));
}

/// After a pause of the servo the force returns gradually, not in one step.
TEST(DeviceExchange, ForceReturnsGraduallyAfterAPause) {
  DeviceExchange exchange;
  exchange.restart();
  exchange.write(Wrench(dvec3(0, 0, 8)));
  ASSERT_TRUE(eventually([&] {
    exchange.write(Wrench(dvec3(0, 0, 8)));
    return exchange.wrench().force_world.z == 8;
  }));
  wait_ms(80);
  ASSERT_TRUE(exchange.wrench().is_zero());
  const double begin = seconds_now();
  double last = 0;
  ASSERT_TRUE(eventually([&] {
    exchange.write(Wrench(dvec3(0, 0, 8)));
    const double force = exchange.wrench().force_world.z, most = 8 * (seconds_now() - begin) / 0.1;
    EXPECT_LE(force, most + 1e-9);
    last = force;
    return force == 8;
  }));
  EXPECT_EQ(last, 8);
}

TEST(TouchDevice, FailuresNameTheirCause) {
  auto& state = touch_state();
  const auto failure = [](TouchChoice choice) {
    TouchDevice device(std::move(choice));
    const Status error = device.open();
    return error ? *error : Error{.what = "no error"};
  };
  TouchChoice absent = touch_choice();
  absent.files = {"libnone_of_this_name.so"};
  const Error library = failure(absent);
  EXPECT_EQ(library.where, "touch: library");
  EXPECT_EQ(library.what, "the library of OpenHaptics is not installed");
  // If the file is another library, the error names the missing function.
  TouchChoice other = touch_choice();
  other.files = {TREPHINE_FAKE_DHD};
  EXPECT_EQ(failure(other).expected, "hdInitDevice");
  // If a dependency of the library is missing, the error reports that the library could not be loaded, and
  // why.
  TouchChoice broken = touch_choice();
  broken.files = {TREPHINE_BROKEN_LIBRARY};
  const Error dependency = failure(broken);
  EXPECT_EQ(dependency.what, "the library of OpenHaptics could not be loaded");
  EXPECT_NE(dependency.found, "");

  state.refuses_to_open = true;
  const Error refused = failure(touch_choice());
  EXPECT_EQ(refused.where, "touch: absent");
  EXPECT_EQ(refused.found, "An error in communicating with the device");
  state.refuses_to_open = false;
  TouchChoice left = touch_choice();
  left.name = "Left Device";
  EXPECT_EQ(failure(left).where, "touch: absent");
  left.name = "Right Device";
  EXPECT_EQ(failure(left).what, "no error");

  state.needs_inkwell = true;
  std::vector<std::string> notices;
  TouchChoice inkwell = touch_choice();
  inkwell.notice = [&](const std::string& text) { notices.push_back(text); };
  EXPECT_EQ(failure(inkwell).where, "touch: not homed");
  EXPECT_EQ(notices.size(), 1u);
  EXPECT_FALSE(state.is_open);
  EXPECT_FALSE(state.is_running);
}

TEST(ForceDimensionDevice, PosesAndWrenchesAreInTheDeviceFrame) {
  auto& state = dhd_state();
  ForceDimensionDevice device(dhd_choice());
  const Status error = device.open();
  ASSERT_FALSE(error) << error->message();
  const DeviceCapabilities c = device.capabilities();
  EXPECT_EQ(c.name, "Force Dimension sigma.7");
  EXPECT_EQ(c.degrees_of_freedom, 6);
  EXPECT_EQ(c.max_force, 20);
  EXPECT_EQ(c.max_torque, 400);
  // The library's frame: x toward the user, y to the right, z up, in m. The tool's axis z is x of the
  // library.
  set(state.position, {0.01, 0.02, 0.03});
  state.buttons = 1;
  expect_pose(device, {20, 30, 10}, {0, 0, 1}, 1);
  set(state.rotation, {0, -1, 0, 1, 0, 0, 0, 0, 1});  // about z by 90 degrees: x turns to y
  expect_pose(device, {20, 30, 10}, {1, 0, 0}, 1);
  EXPECT_TRUE(renders(device, state, Wrench({1, 2, 3}, {100, 200, 300}), {3, 1, 2}));
  EXPECT_LT(glm::length(wrench_part(state, 3) - dvec3(0.3, 0.1, 0.2)), 1e-12);
  device.close();
}

TEST(ForceDimensionDevice, ForceIsZeroUntilWrittenWhenStalledAndAfterClosing) {
  auto& state = dhd_state();
  ForceDimensionDevice device(dhd_choice());
  expect_safe_force(device, state);
  expect_safe_force(device, state);
  expect_loss_and_return(device, state.fails);
}

TEST(ForceDimensionDevice, FailuresNameTheirCause) {
  auto& state = dhd_state();
  const auto failure = [](ForceDimensionChoice choice) {
    ForceDimensionDevice device(std::move(choice));
    const Status error = device.open();
    return error ? error->where + "|" + error->found : std::string();
  };
  EXPECT_EQ(failure({0, {"libnone_of_this_name.so"}}), "omega: library|");
  state.has_no_device = true;
  EXPECT_EQ(failure(dhd_choice()), "omega: absent|0");
  state.has_no_device = false;
  state.refuses_to_open = true;
  EXPECT_EQ(failure(dhd_choice()), "omega: busy|communication error");
  state.refuses_to_open = false;
  state.fails = true;
  EXPECT_EQ(failure(dhd_choice()), "omega: silent|communication error");
  EXPECT_FALSE(state.is_open);
  state.fails = false;
  EXPECT_EQ(failure(dhd_choice()), "");
}
