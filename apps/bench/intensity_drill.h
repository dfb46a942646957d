// IntensityDrill, FixedCountDrill: removal rules of earlier simulators, kept as baselines: in every tick,
// voxels near the tip lose intensity or become air.
#pragma once

#include "volume/scan/volume.h"

namespace trephine::bench {

/// Lowers the intensity near the tip until it is that of air. After Jie Jiang's dissertation (section 6.2.4).
/// The removal depends on the time that the tip stays, on the voxel grid and on the intensities. Positions of
/// the tip between two ticks remove nothing.
class IntensityDrill {
 public:
  static constexpr double k_air = -1000;
  /// `rate`: intensity per second, within a ball of `radius` mm.
  IntensityDrill(volume::Volume scan, double radius, double rate);
  /// Lowers the intensities for a tip that stays at a position for `seconds`. Cost: proportional to the
  /// number of voxels in the ball.
  void stay(const glm::dvec3& tip_world, double seconds) noexcept;
  const volume::Volume& remaining() const noexcept { return scan_; }

 private:
  volume::Volume scan_;
  double radius_, rate_;
};

/// Removes at most `max_voxels` voxels of bone in the ball per tick. This number is independent of the time,
/// the force and the density of the bone (rule of LCSR's volumetric_drilling on AMBF, and of CHAI3D's
/// examples). The published number is 10 voxels per tick for a diameter of 6 mm, and 6 voxels for 4 mm.
class FixedCountDrill {
 public:
  /// `radius`: mm. `max_voxels`: number of voxels per tick.
  FixedCountDrill(volume::Volume scan, double radius, int max_voxels);
  /// `threshold`: lowest intensity of bone.
  void tick(const glm::dvec3& tip_world, double threshold) noexcept;
  const volume::Volume& remaining() const noexcept { return scan_; }

 private:
  volume::Volume scan_;
  double radius_;
  int max_voxels_;
};

}  // namespace trephine::bench
