// MouseDevice: a working tool glides between the positions that a slow display requests.
#include "apps/view/mouse_device.h"

#include <algorithm>
#include <glm/geometric.hpp>
#include <gtest/gtest.h>

namespace trephine::view {
namespace {

using glm::dvec3;

struct Drag {
  double fastest = 0;  ///< mm per tick
  double lag = 0;      ///< mm behind the cursor at the end
};

/// Drags at 10 mm/s, with a request every `interval` seconds.
Drag drag(double interval, bool is_pressed) {
  MouseDevice device(dvec3(0));
  const auto ticks = static_cast<int>(interval * 1000 + 0.5);
  haptics::Pose pose;
  Drag result;
  dvec3 last(0), request(0);
  for (int i = 0; i < 4000; ++i) {
    if (i % ticks == 0) {
      request = {0.01 * i, 0, 0};
      device.set(request, {1, 0, 0, 0}, is_pressed);
    }
    EXPECT_TRUE(device.read(1e-3 * i, pose));
    if (i > 1000) result.fastest = std::max(result.fastest, glm::distance(pose.position_world, last));
    last = pose.position_world;
  }
  result.lag = glm::distance(request, last);
  return result;
}

TEST(MouseDevice, AWorkingToolGlidesBetweenTheRequestsOfASlowDisplay) {
  // At 60 frames per second the tool follows within a fifth of a millimetre.
  const Drag fast = drag(0.016, true);
  EXPECT_LT(fast.fastest, 0.02);
  EXPECT_LT(fast.lag, 0.2);
  // With about three requests per second, a tool that follows at once would move 3 mm within milliseconds and
  // cut dents instead of a groove. A working tool therefore moves slowly.
  EXPECT_LT(drag(0.3, true).fastest, 0.03);
  EXPECT_GT(drag(0.3, false).fastest, 0.15) << "an idle tool follows at once";
}

TEST(MouseDevice, APressGrowsSlowlyAndEndsAtOnce) {
  MouseDevice device(dvec3(0));
  haptics::Pose pose;
  device.set({0, 0, -12}, {1, 0, 0, 0}, true, {}, {0, 0, -12});
  double fastest = 0, last = 0;
  for (int i = 1; i <= 400; ++i) {
    device.read(1e-3 * i, pose);
    fastest = std::max(fastest, last - pose.position_world.z);
    last = pose.position_world.z;
  }
  EXPECT_LT(fastest, 0.0601);
  EXPECT_LT(last, -11.9);
  device.set(dvec3(0), {1, 0, 0, 0}, false);
  for (int i = 401; i <= 500; ++i) device.read(1e-3 * i, pose);
  EXPECT_GT(pose.position_world.z, -0.1);
  // A press that comes with a jump grows slowly, too.
  device.set({40, 0, -12}, {1, 0, 0, 0}, true, dvec3(40, 0, 1), {0, 0, -12});
  device.read(0.501, pose);
  EXPECT_GT(pose.position_world.z, -0.1);
}

TEST(MouseDevice, AJumpIsAtOnce) {
  MouseDevice device(dvec3(0));
  haptics::Pose pose;
  device.set({1, 0, 0}, {1, 0, 0, 0}, true);
  for (int i = 0; i < 100; ++i) device.read(1e-3 * i, pose);
  device.set({40, 0, 0}, {1, 0, 0, 0}, true, dvec3(39, 0, 0));
  device.read(0.1, pose);
  EXPECT_EQ(pose.position_world, dvec3(40, 0, 0));
  EXPECT_EQ(device.fetch_jump(), dvec3(39, 0, 0));
}

}  // namespace
}  // namespace trephine::view
