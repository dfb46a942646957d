#include "apps/workbench/places.h"

#include <algorithm>
#include <glm/geometric.hpp>

#include "haptics/walls/solid_grid.h"
#include "volume/traversal.h"

namespace trephine::workbench {

using glm::dvec3;
using volume::Version;

namespace {

constexpr double k_deepest = 20;  // mm, to which thickness is looked for
constexpr double k_gap = 3;       // mm without solid, after which it has ended
constexpr double k_above = 15;    // mm over and under the place, between which its surface is followed

/// First solid voxel on the way from a to b (world), as a share of it; negative when there is none.
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

/// Where the surface itself is met first, between voxels; the share of the way, negative when it is not.
double first_surface(const haptics::TouchScene& scene, const Version& version, const dvec3& a,
                     const dvec3& b) {
  const double hit = first_solid(scene, version, a, b);
  if (hit < 0) return hit;
  const auto is_inside = [&](double t) {
    return scene.items[0].field.value(scene.base->frame.volume_from_world(a + t * (b - a))) >= 0;
  };
  // A voxel's face lies up to half a voxel outside of what its value says, or inside.
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

double thickness_below(const dvec3& point, const dvec3& outward, const haptics::TouchScene& scene) {
  double end = 0;
  for (double depth = 0.25; depth < k_deepest; depth += 0.25) {
    const glm::ivec3 v = volume::voxel_of(scene.base->frame.volume_from_world(point - depth * outward));
    if (scene.base->contains(v) && scene.items[0].bits->is_solid(v)) end = depth;
    if (depth - end > k_gap) return end;
  }
  return 0;
}

}  // namespace

volume::Result<Place> find_place(const data_tools::ScriptPlace& wish, const haptics::TouchScene& scene,
                                 const Version& untouched) {
  const volume::Frame& frame = scene.base->frame;
  const dvec3 middle = frame.world_from_volume(0.5 * dvec3(scene.base->size - 1));
  const double far = 2 * glm::length(frame.world_from_volume(dvec3(scene.base->size)) - frame.origin());
  for (const dvec3& from : wish.from) {
    const dvec3 outside = middle + far * glm::normalize(from);
    const double hit = first_surface(scene, untouched, outside, middle);
    if (hit < 0) continue;
    Place place;
    place.name = wish.name;
    place.point = outside + hit * (middle - outside);
    int cells = 0;
    place.outward =
        haptics::outward_normal(scene.items[0], untouched, frame.volume_from_world(place.point), cells);
    if (glm::dot(place.outward, glm::normalize(from)) < 0.5) continue;  // a rim, or the wall of a hole
    dvec3 along = glm::cross(wish.up, place.outward);
    if (glm::length(along) < 1e-3) along = glm::cross(dvec3(wish.up.y, wish.up.z, wish.up.x), place.outward);
    place.along = glm::normalize(along);
    place.across = glm::cross(place.outward, place.along);
    place.thickness = thickness_below(place.point, place.outward, scene);
    return place;
  }
  return volume::Error{"no such place was found", "place " + wish.name,
                       "nothing met on " + std::to_string(wish.from.size()) + " ways to the middle",
                       "a surface that faces one of them", "choose other directions, or the shape with iso"};
}

std::vector<haptics::PosePath::Sample> samples_at(const Place& place, const data_tools::ScriptHand& hand,
                                                  const haptics::TouchScene& scene,
                                                  const Version& untouched) {
  // A block that does not end is drilled a blind hole of 8 mm.
  const double through = place.thickness > 0 ? place.thickness : 8;
  std::vector<haptics::PosePath::Sample> samples;
  for (const auto& [t, x, y, z, button, share] : hand.points) {
    const dvec3 above = place.at({x, y, k_above}), below = place.at({x, y, -k_above});
    const double hit = first_surface(scene, untouched, above, below);
    const dvec3 surface = hit < 0 ? place.at({x, y, 0}) : above + hit * (below - above);
    samples.push_back(
        {t, {surface + (z - share * through) * place.outward, {1, 0, 0, 0}, button != 0 ? 1u : 0u}});
  }
  return samples;
}

bool is_open(const Place& place, const haptics::TouchScene& scene, const Version& version) {
  const double end = place.thickness > 0 ? place.thickness : k_deepest;
  return first_solid(scene, version, place.at({0, 0, 5}), place.at({0, 0, -end - 2.5})) < 0;
}

}  // namespace trephine::workbench
