#include "haptics/walls/solid_grid.h"

#include <glm/geometric.hpp>

#include "volume/fields/quadratic_patch.h"

namespace trephine::haptics {

using glm::dvec3;

dvec3 outward_normal(const TouchItem& shape, const volume::Version& version, const dvec3& p,
                     int& cells) noexcept {
  const volume::Frame& frame = version.base().frame;
  const auto unit = [](const dvec3& v) {
    const double length = glm::length(v);
    return length > 0 ? v / length : dvec3(0);
  };
  cells += 8;
  const dvec3 gradient = frame.gradient_world_from_volume(shape.field.smooth_gradient(p));
  if (!version.is_near_cut(p)) return unit(-gradient);
  // The solid is where g >= 0 (field) and d > 0 (distance to removed matter). The nearer boundary counts.
  cells += 3;
  const dvec3 cut_gradient = frame.gradient_world_from_volume(version.distance_gradient(p));
  const double steepness = glm::length(gradient), cut_steepness = glm::length(cut_gradient);
  if (cut_steepness <= 0) return unit(-gradient);
  const double to_field = steepness > 0 ? shape.field.value(p) / steepness : 1e300;
  return version.distance(p) / cut_steepness < to_field ? unit(-cut_gradient) : unit(-gradient);
}

dvec3 OffsetGrid::normal(std::size_t shape, const dvec3& p, int& cells) const noexcept {
  cells += 8;
  const glm::ivec3 v = volume::voxel_of(p);
  volume::QuadraticPatch patch;
  touch_state_.offset(scene_, shape).load(v, patch);
  const dvec3 gradient = frame().gradient_world_from_volume(patch.value_and_gradient(p - dvec3(v)).gradient);
  const double steepness = glm::length(gradient);
  return steepness > 0 ? -gradient / steepness : dvec3(0);
}

}  // namespace trephine::haptics
