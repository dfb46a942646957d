#include "volume/cuts/operated_volume.h"

#include <cmath>
#include <gtest/gtest.h>

#include "volume/cuts/removal.h"

namespace trephine::volume {
namespace {

/// Returns dense bone whose slices have three labels in turn.
std::shared_ptr<const Volume> block(const glm::dvec3& spacing, bool is_hounsfield) {
  const glm::ivec3 size(24, 22, 20);
  Volume v = make_volume(size, Frame::from_spacing({3, -2, 5}, spacing).value(), true).value();
  v.is_hounsfield = is_hounsfield;
  for (int z = 0; z < size.z; ++z)
    for (int y = 0; y < size.y; ++y)
      for (int x = 0; x < size.x; ++x) {
        v.voxels[v.index(x, y, z)] = static_cast<std::int16_t>(1000 + 10 * x - y);
        v.labels[v.index(x, y, z)] = static_cast<std::uint8_t>(1 + z % 3);
      }
  return std::make_shared<Volume>(std::move(v));
}

/// The intensity of a voxel moves toward air by the removed fraction of the voxel. The test estimates this
/// fraction from 216 points per voxel.
TEST(OperatedVolume, MovesVoxelsTowardAirByTheirRemovedFraction) {
  for (const glm::dvec3& spacing : {glm::dvec3(0.5), glm::dvec3(0.5, 0.5, 2)})
    for (const bool is_hounsfield : {true, false}) {
      const auto base = block(spacing, is_hounsfield);
      Shape shape;
      shape.low = 0;
      const double radius = 3;
      const CutLattice lattice = CutLattice::for_burr(*base, 2 * radius).value();
      RemovalEditor editor(std::make_shared<Version>(base, lattice), {Field(*base, shape)});
      const glm::dvec3 middle = base->frame.world_from_volume({12.3, 10.8, 9.7});
      editor.remove({middle, middle, radius, false});
      editor.end_stroke();
      const auto version = editor.publish();
      const auto result = operated_volume(*version);
      ASSERT_TRUE(result);
      const double air = is_hounsfield ? -1000 : 1000 - 21;  // uncalibrated: lowest intensity of the block
      long gone = 0, part = 0;
      for (int z = 0; z < base->size.z; ++z)
        for (int y = 0; y < base->size.y; ++y)
          for (int x = 0; x < base->size.x; ++x) {
            int in_ball = 0;
            constexpr int k_points = 6;
            for (int i = 0; i < k_points * k_points * k_points; ++i) {
              const glm::dvec3 in(i % k_points, i / k_points % k_points, i / (k_points * k_points));
              const glm::dvec3 p = glm::dvec3(x, y, z) + (in + 0.5) / double(k_points) - 0.5;
              in_ball += glm::length(base->frame.world_from_volume(p) - middle) < radius;
            }
            const double share = in_ball / double(k_points * k_points * k_points);
            const std::size_t i = base->index(x, y, z);
            const double was = base->voxels[i], now = result.value().voxels[i];
            ASSERT_NEAR(was - now, share * (was - air), 0.12 * (was - air) + 0.5)
                << x << " " << y << " " << z;
            if (share == 0 && version->removed_share({x, y, z}) == 0) {
              ASSERT_EQ(now, was);
            }
            const bool is_gone = version->removed_share({x, y, z}) == 1;
            ASSERT_EQ(result.value().labels[i], is_gone ? 0 : base->labels[i]);
            gone += is_gone, part += share > 0 && share < 1;
          }
      EXPECT_GT(gone, 50);
      EXPECT_GT(part, 50);
    }
}

}  // namespace
}  // namespace trephine::volume
