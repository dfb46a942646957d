#include "haptics/solid_grid.h"

#include <glm/geometric.hpp>

#include "haptics/explicit_proxy.h"
#include "haptics/smooth_walls.h"
#include "volume/quadratic_patch.h"

namespace trephine::haptics {

using glm::dvec3;

dvec3 outward_normal(const TouchShape& shape, const volume::Version& version, const dvec3& p,
                     int& cells) noexcept {
  const volume::Frame& frame = version.base().frame;
  const auto unit = [](const dvec3& v) {
    const double length = glm::length(v);
    return length > 0 ? v / length : dvec3(0);
  };
  cells += 8;
  const dvec3 slope = frame.gradient_world_from_volume(shape.field.smooth_gradient(p));
  if (!version.is_near_cut(p)) return unit(-slope);
  // Solid = {g >= 0} and {d > 0}: the boundary is the one that leaves less.
  cells += 3;
  const dvec3 cut_slope = frame.gradient_world_from_volume(version.distance_gradient(p));
  const double steepness = glm::length(slope), cut_steepness = glm::length(cut_slope);
  if (cut_steepness <= 0) return unit(-slope);
  const double to_field = steepness > 0 ? shape.field.value(p) / steepness : 1e300;
  return version.distance(p) / cut_steepness < to_field ? unit(-cut_slope) : unit(-slope);
}

bool is_free(const TouchScene& scene, const volume::Version& version, const dvec3& place) noexcept {
  if (scene.shapes.empty()) return true;
  const bool is_round = scene.tool_radius > 0;
  const OffsetGrid lattice(scene, version);
  const VoxelGrid voxels(scene, version);
  const dvec3 p =
      is_round ? lattice.frame().volume_from_world(version.base().frame.world_from_volume(place)) : place;
  const glm::ivec3 v = volume::voxel_of(p);
  ProxyCounters counters;
  const ShapeSet none;
  SmoothWalls walls(scene, version, none, counters);
  for (std::size_t s = 0; s < scene.shapes.size(); ++s) {
    if (&scene.shapes[s].field.volume() != scene.base.get()) break;
    if (is_round ? lattice.is_solid(s, v) : voxels.is_solid(s, v)) return false;
    if (walls.is_solid(static_cast<int>(s), p)) return false;
    if (is_behind_triangles(scene, version, s, place)) return false;
  }
  return true;
}

dvec3 OffsetGrid::normal(std::size_t shape, const dvec3& p, int& cells) const noexcept {
  cells += 8;
  const glm::ivec3 v = volume::voxel_of(p);
  volume::QuadraticPatch patch;
  offset_of(scene_, version_, shape).load(v, patch);
  const dvec3 slope = frame().gradient_world_from_volume(patch.slope(p - dvec3(v)).gradient);
  const double steepness = glm::length(slope);
  return steepness > 0 ? -slope / steepness : dvec3(0);
}

}  // namespace trephine::haptics
