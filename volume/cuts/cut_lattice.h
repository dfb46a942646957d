// CutLattice: sample grid for the distance to removed matter. It subdivides the voxels of a volume so that
// the smallest burr of a session spans several samples for any slice thickness.
#pragma once

#include <glm/common.hpp>
#include <glm/vec3.hpp>

#include "volume/scan/traversal.h"
#include "volume/scan/volume.h"

namespace trephine::volume {

/// Each axis of a voxel is divided by an odd integer. Therefore every voxel's centre is a sample, and the
/// cells of the lattice nest in those of the voxels, both the cells between samples (trilinear interpolation)
/// and those around samples (quadratic splines). The samples extend one brick beyond the voxel grid on each
/// side, because cuts may extend beyond the grid. Lattice frame: continuous sample index, samples at
/// integers.
class CutLattice {
 public:
  static constexpr int k_margin = 8;           ///< samples beyond the voxels on each side
  static constexpr int k_max_per_voxel = 127;  ///< along one axis
  static constexpr double k_samples_per_radius =
      4.5;  ///< fewest samples per radius of a burr, along each axis

  /// Makes a lattice with one sample per voxel.
  explicit CutLattice(const Volume& volume) : CutLattice(volume, glm::ivec3(1)) {}
  /// Makes a lattice as fine along each axis as a burr of this diameter (mm) requires. Error if the diameter
  /// is below smallest_burr_mm().
  static Result<CutLattice> for_burr(const Volume& volume, double diameter_mm);
  /// Returns the smallest diameter (mm) that for_burr() accepts for this volume.
  static double smallest_burr_mm(const Volume& volume) noexcept;

  /// Samples along each axis of a voxel, odd.
  const glm::ivec3& per_voxel() const noexcept { return per_voxel_; }
  bool has_voxel_resolution() const noexcept { return per_voxel_ == glm::ivec3(1); }
  const glm::ivec3& size() const noexcept { return size_; }
  const Frame& frame() const noexcept { return frame_; }  ///< world frame of the samples

  bool contains(const glm::ivec3& s) const noexcept {
    return s.x >= 0 && s.y >= 0 && s.z >= 0 && s.x < size_.x && s.y < size_.y && s.z < size_.z;
  }
  /// Sample at a voxel's centre.
  glm::ivec3 centre_of(const glm::ivec3& voxel) const noexcept { return voxel * per_voxel_ + first_centre_; }
  /// First and last samples in a voxel's cube.
  glm::ivec3 low_of(const glm::ivec3& voxel) const noexcept { return voxel * per_voxel_ + k_margin; }
  glm::ivec3 high_of(const glm::ivec3& voxel) const noexcept { return low_of(voxel) + per_voxel_ - 1; }
  /// Voxel whose cube contains a sample, also beyond the grid.
  glm::ivec3 voxel_of(const glm::ivec3& sample) const noexcept {
    glm::ivec3 v;
    for (int a = 0; a < 3; ++a) {
      const int s = sample[a] - k_margin, k = per_voxel_[a];
      v[a] = s >= 0 ? s / k : -((-s + k - 1) / k);
    }
    return v;
  }
  glm::dvec3 lattice_from_volume(const glm::dvec3& p) const noexcept {
    return p * scale_ + glm::dvec3(first_centre_);
  }
  glm::dvec3 volume_from_lattice(const glm::dvec3& s) const noexcept {
    return (s - glm::dvec3(first_centre_)) / scale_;
  }
  /// A point as the sample whose cube contains it and the offset from that sample, in steps, each coordinate
  /// in [-0.5, 0.5] up to rounding.
  struct Point {
    glm::ivec3 sample;
    glm::dvec3 at;
  };
  /// Returns the sample and the offset of a point p (volume frame).
  Point point_of(const glm::dvec3& p) const noexcept {
    const glm::ivec3 v = volume::voxel_of(p);
    const glm::dvec3 steps = (p - glm::dvec3(v)) * scale_;
    const glm::ivec3 half = (per_voxel_ - 1) / 2, s = glm::clamp(volume::voxel_of(steps), -half, half);
    return {centre_of(v) + s, steps - glm::dvec3(s)};
  }
  /// Samples per voxel step: converts derivatives in the lattice frame to the volume frame.
  const glm::dvec3& scale() const noexcept { return scale_; }

 private:
  CutLattice(const Volume& volume, const glm::ivec3& per_voxel);

  glm::ivec3 per_voxel_, size_, first_centre_;
  glm::dvec3 scale_;
  Frame frame_;
};

}  // namespace trephine::volume
