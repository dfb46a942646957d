#include "modules/skull_clamp/head_contact.h"

#include <algorithm>
#include <glm/geometric.hpp>

#include "volume/base/axes.h"
#include "volume/base/deterministic_math.h"
#include "volume/scan/traversal.h"

namespace trephine::skull_clamp {

using glm::dvec3;

namespace {

constexpr double k_skin = -300;   // HU, between air and fat
constexpr double k_step = 0.5;    // mm
constexpr double k_deepest = 60;  // mm, largest depth that is measured

/// Returns the distance from a point in the head to the surface of the head, mm: the least along 26
/// directions, at most k_deepest.
double depth_in(const HeadSolid& head, const dvec3& p) {
  double least = k_deepest;
  for (int z = -1; z <= 1; ++z)
    for (int y = -1; y <= 1; ++y)
      for (int x = -1; x <= 1; ++x) {
        if (x == 0 && y == 0 && z == 0) continue;
        const dvec3 direction = glm::normalize(dvec3(x, y, z));
        double along = k_step;
        while (along < least && head.contains(p + along * direction)) along += k_step;
        least = std::min(least, along);
      }
  return least;
}

}  // namespace

HeadSolid::HeadSolid(const volume::Field& bone) : bone_(bone) {
  const volume::Volume& scan = bone.volume();
  const bool has_scalp =
      !scan.labels.is_empty() &&
      (scan.label_value("scalp") > 0 || scan.label_value("skin") > 0 || scan.label_value("soft_tissue") > 0);
  if (has_scalp)
    kind_ = Kind::labels;
  else if (scan.is_hounsfield)
    kind_ = Kind::intensities;
}

bool HeadSolid::contains(const dvec3& p_world) const noexcept {
  const volume::Volume& scan = bone_.volume();
  const dvec3 p = scan.frame.volume_from_world(p_world);
  const glm::ivec3 v = volume::voxel_of(p);
  if (!scan.contains(v)) return false;
  const std::size_t index = scan.index(v.x, v.y, v.z);
  if (kind_ == Kind::labels) return scan.labels[index] != 0;
  return kind_ == Kind::intensities ? scan.voxels[index] >= k_skin : bone_.value(p) >= 0;
}

double HeadSolid::thickness(const dvec3& table_world, const dvec3& outward, double reach) const noexcept {
  constexpr double k_fine = 0.1, k_gap = 1;  // mm
  double last = 0;
  for (double along = k_fine; along <= reach && along - last <= k_gap; along += k_fine)
    if (contains(table_world + along * outward)) last = along;
  return last;
}

HeadContact head_contact(const HeadSolid& head, std::span<const ClampRod> rods) {
  constexpr int k_around = 16;
  HeadContact contact;
  for (const ClampRod& rod : rods) {
    const double length = glm::distance(rod.from, rod.to);
    if (!(length > 0)) continue;
    const dvec3 along = (rod.to - rod.from) / length;
    const auto [right, up] = volume::perpendicular_axes(along);
    const int count = std::max(1, static_cast<int>(length / k_step));
    for (int i = 0; i < count; ++i) {
      const dvec3 middle = rod.from + (i + 0.5) / count * length * along;
      bool is_inside = false;
      for (int k = 0; k < k_around; ++k) {
        const double angle = 6.283185307179586 * k / k_around;
        const dvec3 p =
            middle + rod.radius * (deterministic_cos(angle) * right + deterministic_sin(angle) * up);
        if (!head.contains(p)) continue;
        is_inside = true;
        if (const double depth = depth_in(head, p); depth > contact.depth)
          contact.depth = depth, contact.at_world = p;
      }
      if (is_inside) contact.length += length / count;
    }
  }
  return contact;
}

}  // namespace trephine::skull_clamp
