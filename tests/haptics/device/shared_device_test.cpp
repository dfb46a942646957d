// SharedDevice: a device whose pose another program provides.
#include "haptics/device/shared_device.h"

#include <fstream>
#include <glm/geometric.hpp>
#include <gtest/gtest.h>
#include <limits>
#include <unistd.h>

namespace trephine::haptics {
namespace {

SharedPose pose_at(std::uint64_t count, double x) { return {count, {x, 2, 3}, {0, 0, 1, 0}, 5}; }

TEST(SharedDevice, PosesAndWrenchesPassBetweenPrograms) {
  constexpr int k_index = 1;
  EXPECT_FALSE(SharedDeviceMemory::exists(k_index));
  SharedDevice device(k_index);
  const Status absent = device.open();
  ASSERT_TRUE(absent);
  EXPECT_EQ(absent->what, "the virtual device is not open");
  const auto host = SharedDeviceMemory::create(k_index);
  ASSERT_TRUE(host) << host.error().message();
  EXPECT_TRUE(SharedDeviceMemory::exists(k_index));
  const auto second = SharedDeviceMemory::create(k_index);
  ASSERT_FALSE(second);
  EXPECT_EQ(second.error().what, "a virtual device with this index is already open");
  SharedDeviceMemory& memory = *host.value();
  memory.set_pose(pose_at(1, 10));
  ASSERT_FALSE(device.open());
  Pose pose;
  ASSERT_TRUE(device.read(0, pose));
  EXPECT_EQ(pose.position_world, glm::dvec3(10, 2, 3));
  EXPECT_EQ(pose.orientation, glm::dquat(0, 0, 1, 0));
  EXPECT_EQ(pose.buttons, 5u);
  device.write({{1, 2, 3}, {4, 5, 6}});
  const auto wrench = memory.wrench();
  ASSERT_TRUE(wrench);
  EXPECT_EQ(wrench->count, 1u);
  EXPECT_EQ(wrench->force[1], 2);
  EXPECT_EQ(wrench->torque[2], 6);
  device.close();
  EXPECT_EQ(memory.wrench()->force[1], 0);
  EXPECT_FALSE(device.read(0, pose));
}

TEST(SharedDevice, ASilentOrDamagedHostIsALostDevice) {
  const auto host = SharedDeviceMemory::create(2);
  ASSERT_TRUE(host) << host.error().message();
  SharedDeviceMemory& memory = *host.value();
  SharedDevice device(2);
  ASSERT_FALSE(device.open());
  Pose pose;
  memory.set_pose(pose_at(1, 10));
  EXPECT_TRUE(device.read(1, pose));
  EXPECT_TRUE(device.read(1.09, pose));
  EXPECT_FALSE(device.read(1.11, pose));
  memory.set_pose(pose_at(2, 11));
  EXPECT_TRUE(device.read(1.2, pose));
  EXPECT_EQ(pose.position_world.x, 11);
  for (const double x : {std::numeric_limits<double>::quiet_NaN(), 1e300, -2e4}) {
    static std::uint64_t count = 2;
    memory.set_pose(pose_at(++count, x));
    EXPECT_FALSE(device.read(1.2, pose)) << x;
    EXPECT_EQ(pose.position_world.x, 11);
  }
  SharedPose turned = pose_at(9, 1);
  for (double& q : turned.orientation) q = std::numeric_limits<double>::quiet_NaN();
  memory.set_pose(turned);
  ASSERT_TRUE(device.read(1.2, pose));
  EXPECT_EQ(pose.orientation, glm::dquat(1, 0, 0, 0));
}

/// The file of a host that was killed has no lock: it is no device, and the next host takes it.
TEST(SharedDevice, TheFileOfADeadHostIsTakenOver) {
  const std::string file = "/dev/shm/trephine-virtual-" + std::to_string(::getuid()) + "-3";
  std::string left = "TREPHDEV";
  left.append("\x01\0\0\0", 4).resize(4096);
  left[200] = 7;  // a wrench
  std::ofstream(file) << left;
  EXPECT_FALSE(SharedDeviceMemory::exists(3));
  SharedDevice device(3);
  EXPECT_TRUE(device.open());
  {
    const auto host = SharedDeviceMemory::create(3);
    ASSERT_TRUE(host) << host.error().message();
    EXPECT_FALSE(host.value()->wrench()) << "the wrench of an earlier program does not act";
    EXPECT_FALSE(device.open());
    // Another program must not use the device at the same time.
    SharedDevice second(3);
    const Status used = second.open();
    ASSERT_TRUE(used);
    EXPECT_EQ(used->what, "another program uses the virtual device");
    device.close();
    EXPECT_FALSE(second.open());
    // A file that is truncated gives no pose, and does no harm.
    host.value()->set_pose(pose_at(1, 4));
    Pose pose;
    EXPECT_TRUE(second.read(0, pose));
    ASSERT_EQ(::truncate(file.c_str(), 0), 0);
    second.write({{1, 0, 0}});
    EXPECT_FALSE(second.read(1, pose));
    host.value()->set_pose(pose_at(2, 5));
    EXPECT_TRUE(second.read(1, pose));
  }
  EXPECT_NE(::access(file.c_str(), F_OK), 0);
  // A file of another kind is neither used nor deleted.
  std::ofstream(file) << "notes";
  const auto foreign = SharedDeviceMemory::create(3);
  ASSERT_FALSE(foreign);
  EXPECT_TRUE(foreign.error().what.starts_with("another file has the name of the virtual device"));
  EXPECT_EQ(::unlink(file.c_str()), 0);
  // A link to another file is not followed.
  ASSERT_EQ(::symlink("/dev/null", file.c_str()), 0);
  EXPECT_FALSE(SharedDeviceMemory::create(3));
  ::unlink(file.c_str());
}

}  // namespace
}  // namespace trephine::haptics
