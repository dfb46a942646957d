// The way of the first volume-haptics simulators, kept as a baseline: in every tick voxels near the tip lose
// intensity, until they are air.
#pragma once

#include "volume/volume.h"

namespace trephine::drilling {

/// After Jie Jiang's dissertation (section 6.2.4). What it takes depends on how long the tip stays, on voxels
/// and on their values; nothing lies between two ticks.
class IntensityDrill {
 public:
  static constexpr double k_air = -1000;
  /// `rate`: of intensity a second, within a ball of `radius` mm.
  IntensityDrill(volume::Volume scan, double radius, double rate);
  /// The tip is here for `seconds`. Cost: the voxels of the ball.
  void stay(const glm::dvec3& tip_world, double seconds) noexcept;
  const volume::Volume& left() const noexcept { return scan_; }

 private:
  volume::Volume scan_;
  double radius_, rate_;
};

/// The other rule in use (LCSR's volumetric_drilling on AMBF, CHAI3D's examples): in every tick so many
/// voxels of the ball go, whatever the time, the press or the bone. A ball of 6 mm takes 10, of 4 mm 6.
class VoxelsATick {
 public:
  VoxelsATick(volume::Volume scan, double radius, int most);
  /// `threshold`: from which on a voxel is bone.
  void tick(const glm::dvec3& tip_world, double threshold) noexcept;
  const volume::Volume& left() const noexcept { return scan_; }

 private:
  volume::Volume scan_;
  double radius_;
  int most_;
};

}  // namespace trephine::drilling
