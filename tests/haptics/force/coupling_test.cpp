// Couplings that a device renders passively, and limits that devices set.
#include "haptics/force/coupling.h"

#include <cmath>
#include <gtest/gtest.h>

namespace trephine::haptics {
namespace {

TEST(Coupling, IsTheStiffestForTheDeviceAndMatchesThePublishedExample) {
  const Coupling c = critical_coupling(0.025, 0.008, 1000);
  EXPECT_NEAR(c.stiffness, 0.5934, 5e-5);  // N/mm; Kadlecek 2013, master thesis, eq. 3.24
  EXPECT_NEAR(c.damping, 2 * std::sqrt(c.stiffness * 0.025 / 1000), 1e-12);
  EXPECT_NEAR(0.5e-3 * c.stiffness + c.damping, 0.008, 1e-12);
  EXPECT_DOUBLE_EQ(passive_stiffness(0.002, 0.001, 1000), 2);
  EXPECT_DOUBLE_EQ(passive_stiffness(0.002, 0.003, 1000), 0);
}

TEST(Coupling, DevicesLimitForceSlewAndStiffness) {
  DeviceCapabilities small{"small", 3, 3.3, 0.6, 80, 500, 0.05, 0.002};
  const ForceOptions f = within_limits(ForceOptions{}, small);
  EXPECT_EQ(f.force_limit, 3.3);
  EXPECT_EQ(f.slew_limit, 500);
  EXPECT_EQ(within_limits(Material{2, 0, 0, 0}, small).stiffness, 0.6);
  EXPECT_EQ(within_limits(Material{0.4, 0, 0, 0}, small).stiffness, 0.4);
  const DeviceCapabilities silent{"mouse", 3, 0, 0, 1e3};
  EXPECT_EQ(within_limits(ForceOptions{}, silent).force_limit, ForceOptions{}.force_limit);
}

}  // namespace
}  // namespace trephine::haptics
