// Frame: general affine map between the voxel index of a volume and the world.
// Volume frame: continuous voxel index (x, y, z), voxel centres at integers. World: DICOM LPS, mm.
#pragma once

#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>

#include "volume/base/error.h"

namespace trephine::volume {

class Frame {
 public:
  /// Axis-aligned, 1 mm, origin 0.
  Frame() = default;

  /// Columns of `axes_mm` are the world displacements (mm) of one step along x, y, z; `origin_world` is the
  /// centre of voxel (0, 0, 0). Shear is allowed. Error if a value is not finite or the axes are dependent.
  static Result<Frame> from_axes(const glm::dvec3& origin_world, const glm::dmat3& axes_mm);

  /// Axis-aligned frame with `spacing_mm` between voxel centres. Error unless all are finite and above 0.
  static Result<Frame> from_spacing(const glm::dvec3& origin_world, const glm::dvec3& spacing_mm);

  glm::dvec3 world_from_volume(const glm::dvec3& p) const noexcept { return origin_ + axes_ * p; }
  glm::dvec3 volume_from_world(const glm::dvec3& p) const noexcept { return inverse_ * (p - origin_); }
  glm::dvec3 vector_world_from_volume(const glm::dvec3& v) const noexcept { return axes_ * v; }
  glm::dvec3 vector_volume_from_world(const glm::dvec3& v) const noexcept { return inverse_ * v; }
  /// Converts a gradient (a covector) from per voxel step to per mm.
  glm::dvec3 gradient_world_from_volume(const glm::dvec3& g) const noexcept { return g * inverse_; }

  const glm::dvec3& origin() const noexcept { return origin_; }
  const glm::dmat3& axes() const noexcept { return axes_; }
  const glm::dvec3& spacing() const noexcept { return spacing_; }  ///< mm, length of each axis step
  double voxel_mm3() const noexcept;                               ///< volume of a voxel
  double diagonal_mm() const noexcept;                             ///< longest diagonal of a voxel
  bool is_orthogonal() const noexcept;  ///< true if |cosine| is below 1e-5 for each pair of axes
  friend bool operator==(const Frame&, const Frame&) = default;

 private:
  glm::dvec3 origin_{0.0};
  glm::dmat3 axes_{1.0};
  glm::dmat3 inverse_{1.0};
  glm::dvec3 spacing_{1.0};
};

}  // namespace trephine::volume
