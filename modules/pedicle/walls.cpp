#include "modules/pedicle/walls.h"

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "volume/base/deterministic_math.h"
#include "volume/scan/traversal.h"

namespace trephine::pedicle {

using glm::dvec3;

namespace {

/// Returns the first label along the tool from an entry, and sets `at` to its position; 0: no label within
/// reach.
int label_below(const volume::Volume& scan, const dvec3& entry, const dvec3& ahead, dvec3& at) noexcept {
  constexpr double k_step = 0.5, k_reach = 8;  // mm
  if (scan.labels.is_empty()) return 0;
  for (double t = 0; t <= k_reach; t += k_step) {
    at = entry + t * ahead;
    const glm::ivec3 v = volume::voxel_of(scan.frame.volume_from_world(at));
    if (!scan.contains(v)) continue;
    if (const int label = scan.labels[scan.index(v.x, v.y, v.z)]; label > 0) return label;
  }
  return 0;
}

/// Returns true if bone surrounds a point in the axial plane, as it does in the spinal canal.
bool is_surrounded(const sim::Work& work, const dvec3& p) noexcept {
  constexpr int k_directions = 16, k_enough = 13;  // a foramen and a track may be open
  constexpr double k_step = 1, k_far = 26;         // mm, the width of a lumbar canal
  int count = 0;
  for (int i = 0; i < k_directions; ++i) {
    const double angle = 2 * 3.14159265358979323846 * i / k_directions;
    const dvec3 to(deterministic_cos(angle), deterministic_sin(angle), 0);
    for (double t = k_step; t <= k_far; t += k_step)
      if (work.is_matter(p + t * to)) {
        ++count;
        break;
      }
  }
  return count >= k_enough;
}

}  // namespace

double side_of_midline(const volume::Volume& scan, const dvec3& entry, const dvec3& ahead) noexcept {
  dvec3 at = entry;
  const int label = label_below(scan, entry, ahead, at);
  if (label <= 0) return ahead.x > 0 ? 1 : -1;
  // The slice through `at`, across the axis of the grid that is nearest to the patient's long axis.
  int across = 0;
  double most = -1;
  for (int a = 0; a < 3; ++a) {
    dvec3 step(0);
    step[a] = 1;
    const dvec3 axis = scan.frame.world_from_volume(step) - scan.frame.world_from_volume(dvec3(0));
    if (const double rise = glm::abs(axis.z) / glm::length(axis); rise > most) most = rise, across = a;
  }
  const int u = (across + 1) % 3, w = (across + 2) % 3;
  glm::ivec3 v = volume::voxel_of(scan.frame.volume_from_world(at));
  double sum = 0, count = 0;
  for (v[u] = 0; v[u] < scan.size[u]; ++v[u])
    for (v[w] = 0; v[w] < scan.size[w]; ++v[w])
      if (scan.labels[scan.index(v.x, v.y, v.z)] == label)
        sum += scan.frame.world_from_volume(dvec3(v)).x, ++count;
  return count > 0 && sum / count > entry.x ? 1 : -1;
}

dvec3 direction_out_of_bone(const sim::Work& work, const dvec3& tip, const dvec3& ahead) noexcept {
  constexpr double k_radii[] = {1.5, 2.5};  // mm
  constexpr double k_behind = -0.5;         // cosine to `ahead`: smaller ones are in the track
  dvec3 free(0), all(0);
  double free_count = 0, count = 0;
  for (int z = -2; z <= 2; ++z)
    for (int y = -2; y <= 2; ++y)
      for (int x = -2; x <= 2; ++x) {
        if (x == 0 && y == 0 && z == 0) continue;
        const dvec3 direction = glm::normalize(dvec3(x, y, z));
        if (glm::dot(direction, ahead) < k_behind) continue;
        for (const double radius : k_radii) {
          const double is_free = work.is_matter(tip + radius * direction) ? 0 : 1;
          free += is_free * direction, all += direction;
          free_count += is_free, ++count;
        }
      }
  // Directions are not evenly distributed, since those of the track are left out.
  const dvec3 out = free - free_count / count * all;
  const double size = glm::length(out);
  return size > 1e-9 ? out / size : ahead;
}

Wall wall_at(const sim::Work& work, const dvec3& tip, const dvec3& ahead, double midline) noexcept {
  constexpr double k_beyond = 2;  // mm from the tip into the free space
  const dvec3 out = direction_out_of_bone(work, tip, ahead);
  if (is_surrounded(work, tip + k_beyond * out)) return Wall::medial;
  const std::array<std::pair<double, Wall>, 5> candidates{{{midline * out.x, Wall::medial},
                                                           {-midline * out.x, Wall::lateral},
                                                           {out.z, Wall::above},
                                                           {-out.z, Wall::below},
                                                           {-out.y, Wall::front}}};
  Wall wall = Wall::front;
  double most = -1;
  for (const auto& [along, name] : candidates)
    if (along > most) most = along, wall = name;
  return wall;
}

}  // namespace trephine::pedicle
