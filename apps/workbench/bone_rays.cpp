#include "apps/workbench/bone_rays.h"

#include <algorithm>
#include <glm/geometric.hpp>

#include "volume/scan/traversal.h"

namespace trephine::workbench {

using glm::dvec3;
using volume::Version;

double first_solid(const haptics::TouchScene& scene, const Version& version, const dvec3& a, const dvec3& b) {
  double hit = -1;
  const volume::Frame& frame = scene.base->frame;
  volume::traverse(frame.volume_from_world(a), frame.volume_from_world(b),
                   {glm::ivec3(0), scene.base->size - 1}, [&](const volume::VoxelVisit& v) {
                     if (!scene.items[0].bits->is_solid(v.voxel) || !version.is_kept(v.voxel)) return true;
                     hit = v.t_enter;
                     return false;
                   });
  return hit;
}

double first_surface(const haptics::TouchScene& scene, const Version& version, const dvec3& a,
                     const dvec3& b) {
  const double hit = first_solid(scene, version, a, b);
  if (hit < 0) return hit;
  const auto is_inside = [&](double t) {
    return scene.items[0].field.value(scene.base->frame.volume_from_world(a + t * (b - a))) >= 0;
  };
  // The surface is near the face of the voxel, outside or inside: it is searched a voxel to either side.
  const dvec3& spacing = scene.base->frame.spacing();
  const double voxel = std::max({spacing.x, spacing.y, spacing.z}) / glm::length(b - a), step = 0.05 * voxel;
  double outside = std::max(0.0, hit - voxel), inside = outside;
  while (inside < hit + voxel && !is_inside(inside)) outside = inside, inside += step;
  if (!is_inside(inside)) return hit;
  for (int i = 0; i < 20; ++i) {
    const double middle = 0.5 * (outside + inside);
    (is_inside(middle) ? inside : outside) = middle;
  }
  return inside;
}

}  // namespace trephine::workbench
