// Field: continuous scalar field g of a shape, trilinear between voxel centres; g >= 0 is solid.
#pragma once

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/vec3.hpp>

#include "volume/scan/shape.h"
#include "volume/scan/volume.h"

namespace trephine::volume {

/// Value of a field beyond the grid, next to a voxel with value `g`: negative (not solid), also if g is 0.
inline double beyond_border(double g) noexcept {
  constexpr double k_min = 1e-9;
  return -std::max(std::abs(g), k_min);
}

/// Borrows its volume. Queries are noexcept, allocate nothing and take points in the volume frame.
class Field {
 public:
  Field() noexcept = default;  ///< has no volume and must not be queried
  Field(const Volume& volume, const Shape& shape) noexcept : volume_(&volume), shape_(shape) {}

  /// g at a voxel centre. Beyond the grid is air, with -|g| of the nearest voxel: the surface of a solid that
  /// reaches the border is on the outer faces of its voxels, for any unit of intensity.
  double at(int x, int y, int z) const noexcept {
    if (volume_->contains({x, y, z})) return at_index(volume_->index(x, y, z));
    const glm::ivec3 v = glm::clamp(glm::ivec3(x, y, z), glm::ivec3(0), volume_->size - 1);
    return beyond_border(at_index(volume_->index(v.x, v.y, v.z)));
  }
  /// g of the voxel stored at `index`. Does not check the index.
  double at_index(std::size_t index) const noexcept {
    if (shape_.is_label()) return volume_->labels[index] == shape_.label ? 0.5 : -0.5;
    const double intensity = volume_->window_voxels()[index];
    return std::min(intensity - shape_.low, shape_.high - intensity);
  }
  /// Trilinear value at p.
  double value(const glm::dvec3& p) const noexcept;
  /// Exact gradient of the trilinear value, per voxel step; on a cell face that of the higher cell.
  glm::dvec3 gradient(const glm::dvec3& p) const noexcept;
  /// Interpolates the central differences at the eight voxel centres around p: continuous everywhere, for
  /// normals (Levoy 1988, eq. 4). Per voxel step. Uses 32 samples.
  glm::dvec3 smooth_gradient(const glm::dvec3& p) const noexcept;

  const Volume& volume() const noexcept { return *volume_; }
  const Shape& shape() const noexcept { return shape_; }

 private:
  const Volume* volume_ = nullptr;
  Shape shape_;
};

}  // namespace trephine::volume
