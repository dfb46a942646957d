// Operations of the C++ interface for tests: a cube of bone, a burr, and holes.
#pragma once

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>

#include "apps/api/operation.h"

namespace trephine {

using glm::dvec3;

inline const Hand k_burr{.instrument = "burr", .parameters = "diameter=4 removal_rate=30"};

inline OperationOptions with_burr() {
  OperationOptions options;
  options.hands = {k_burr};
  return options;
}

/// A cube of bone in air, its edges 16 mm, with the soft border of a scan.
inline std::shared_ptr<const Volume> cube() {
  auto made =
      volume::make_volume(glm::ivec3(48), volume::Frame::from_spacing(dvec3(-12), dvec3(0.5)).value());
  EXPECT_TRUE(made.is_ok());
  Volume& scan = made.value();
  scan.is_hounsfield = true;
  for (int z = 0; z < 48; ++z)
    for (int y = 0; y < 48; ++y)
      for (int x = 0; x < 48; ++x) {
        const double outside = std::max({std::abs(x - 23.5), std::abs(y - 23.5), std::abs(z - 23.5)}) - 16;
        scan.voxels[scan.index(x, y, z)] =
            static_cast<std::int16_t>(std::clamp(300 - 500 * outside, -1000.0, 1000.0));
      }
  return std::make_shared<const Volume>(std::move(made).value());
}

inline Operation opened(const OperationOptions& options = with_burr()) {
  auto result = Operation::open(cube(), options);
  EXPECT_TRUE(result.is_ok()) << (result ? "" : result.error().message());
  return std::move(result).value();
}

/// Drills a hole into the top of the cube.
inline void drill(Operation& operation, double x, int ticks = 300) {
  std::vector<Pose> path(static_cast<std::size_t>(ticks));
  for (int i = 0; i < ticks; ++i) {
    Pose& pose = path[static_cast<std::size_t>(i)];
    pose.position_world = {x, 0, i < ticks - 10 ? 8.5 - 0.01 * i : 12.0};
    pose.press(i < ticks - 10);
  }
  ASSERT_TRUE(operation.run(path).is_ok());
}

}  // namespace trephine
