// VirtualDeviceHost: the simulated hand of trephine virtual-device.
#include "apps/workbench/virtual_device.h"

#include <chrono>
#include <cmath>
#include <glm/geometric.hpp>
#include <gtest/gtest.h>
#include <thread>

namespace trephine::workbench {
namespace {

/// Calls a function every 2 ms until it returns true; false after a minute.
template <class Holds>
bool eventually(Holds holds) {
  for (int i = 0; i < 30'000; ++i) {
    if (holds()) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  return false;
}

TEST(VirtualDeviceHost, TheHandFollowsRequestsAndYieldsToWrenches) {
  VirtualDeviceOptions options;
  options.index = 4;
  options.record_seconds = 60;
  const auto host_of = VirtualDeviceHost::open(options);
  ASSERT_TRUE(host_of) << host_of.error().message();
  VirtualDeviceHost& host = *host_of.value();
  haptics::Pose request;
  request.position_world = {20, 0, 0};
  request.press(true);
  host.request(request);
  haptics::SharedDevice device(4);
  ASSERT_FALSE(device.open());
  haptics::Pose pose;
  EXPECT_TRUE(eventually([&] {
    device.read(host.state().seconds, pose);
    return std::abs(pose.position_world.x - 20) < 0.05 && pose.is_pressed();
  }));
  // A force of 3 N displaces a hand of 0.3 N/mm by 10 mm; a torque of 24 N mm turns it by
  // 24 / (0.3 * 20^2) = 0.2 rad.
  const auto yields = [&](const haptics::Wrench& wrench, double mm, double rad) {
    return eventually([&] {
      device.write(wrench);
      device.read(host.state().seconds, pose);
      return std::abs(20 + mm - pose.position_world.x) < 0.1 && std::abs(2 * pose.orientation.z - rad) < 0.01;
    });
  };
  EXPECT_TRUE(yields({{3, 0, 0}, {0, 0, 24}}, 10, 0.2));
  EXPECT_TRUE(host.state().is_connected);
  EXPECT_TRUE(eventually([&] {
    device.write({{3, 0, 0}, {0, 0, 24}});
    const auto intervals = host.intervals();
    return !intervals.empty() && std::abs(intervals.back().mean_force - 3) < 1e-9 &&
           std::abs(intervals.back().noisy_torque - 24) < 1e-9;
  }));
  // Wrenches that are not finite have no effect.
  EXPECT_TRUE(yields({{std::nan(""), 0, 0}, {0, 0, 24}}, 0, 0));
  device.close();
  EXPECT_TRUE(eventually([&] { return !host.state().is_connected; }));
  const auto recording = host.recording();
  ASSERT_TRUE(recording) << recording.error().message();
  EXPECT_GT(recording.value().samples().size(), 20u);
}

/// A program that is killed sends no last wrench. The force ends, because no further wrench arrives.
TEST(VirtualDeviceHost, TheForceEndsIfNoWrenchArrives) {
  VirtualDeviceOptions options;
  options.index = 5;
  const auto host = VirtualDeviceHost::open(options);
  ASSERT_TRUE(host);
  const auto memory = haptics::SharedDeviceMemory::open(5);
  ASSERT_TRUE(memory);
  EXPECT_TRUE(eventually([&, count = std::uint64_t{0}]() mutable {
    memory.value()->set_wrench({++count, {4, 0, 0}, {0, 0, 0}});
    return host.value()->state().is_connected;
  }));
  EXPECT_TRUE(eventually([&] { return host.value()->state().wrench.is_zero(); }));
}

TEST(VirtualDeviceHost, PlaysAMotionAndFollowsAnAttachedDevice) {
  std::vector<haptics::PosePath::Sample> samples(2);
  samples[0].t = 0, samples[1].t = 0.2;
  samples[1].pose.position_world = {0, 30, 0};
  const auto motion = haptics::PosePath::from_samples(samples, "test").value();
  for (const bool is_attached : {false, true}) {
    VirtualDeviceOptions options;
    options.index = 6;
    if (is_attached)
      options.attached = std::make_shared<haptics::PlaybackDevice>(motion);
    else
      options.motion = motion;
    const auto host = VirtualDeviceHost::open(options);
    ASSERT_TRUE(host);
    EXPECT_TRUE(eventually([&] {
      const auto state = host.value()->state();
      return std::abs(state.pose.position_world.y - 30) < 0.1 && !state.is_playing;
    }));
  }
}

}  // namespace
}  // namespace trephine::workbench
