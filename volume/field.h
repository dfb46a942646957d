// The continuous field of a shape, trilinear between voxel centres; g >= 0 is solid.
#pragma once

#include <glm/vec3.hpp>

#include "volume/shape.h"
#include "volume/volume.h"

namespace trephine::volume {

/// Borrows its volume. Every query is noexcept, allocates nothing and takes points in the volume frame.
class Field {
 public:
  Field(const Volume& volume, const Shape& shape) noexcept
      : volume_(&volume), shape_(shape), outside_(shape.outside()) {}

  /// g at a voxel centre; Shape::outside() beyond the grid.
  double at(int x, int y, int z) const noexcept {
    if (!volume_->contains({x, y, z})) return outside_;
    return at_index(volume_->index(x, y, z));
  }
  /// g of the voxel stored at `index`, which is not checked.
  double at_index(std::size_t index) const noexcept {
    if (shape_.is_label()) return volume_->labels[index] == shape_.label ? 0.5 : -0.5;
    const double intensity = volume_->voxels[index];
    return std::min(intensity - shape_.low, shape_.high - intensity);
  }
  /// Trilinear value at p.
  double value(const glm::dvec3& p) const noexcept;
  /// Exact gradient of the trilinear value, per voxel step; at a cell face that of the higher cell.
  glm::dvec3 gradient(const glm::dvec3& p) const noexcept;
  /// Central differences at the eight voxel centres around p, interpolated: continuous everywhere, for
  /// normals (Levoy 1988, eq. 4). 32 samples.
  glm::dvec3 smooth_gradient(const glm::dvec3& p) const noexcept;

  const Volume& volume() const noexcept { return *volume_; }
  const Shape& shape() const noexcept { return shape_; }

 private:
  const Volume* volume_;
  Shape shape_;
  double outside_;
};

}  // namespace trephine::volume
