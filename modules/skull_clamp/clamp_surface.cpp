#include "modules/skull_clamp/clamp_surface.h"

#include <cmath>
#include <glm/geometric.hpp>
#include <vector>

#include "volume/base/axes.h"
#include "volume/base/deterministic_math.h"
#include "volume/surface/lathe.h"

namespace trephine::skull_clamp {

using glm::dvec3;

namespace {

// Sizes in mm, assumed.
constexpr double k_pin_cone = 6, k_pin_radius = 3, k_pin_length = 40;
constexpr double k_arm_radius = 8, k_rocker_radius = 6;
constexpr int k_facets = 10;

/// Collects turned solids: closed surfaces about straight axes.
class Parts {
 public:
  void rod(const dvec3& from, const dvec3& to, double radius) {
    const double length = glm::distance(from, to);
    if (!(length > 0)) return;
    const volume::TurnedRing rings[] = {{0, radius}, {length, radius}};
    add(from, (to - from) / length, volume::turned_solid(0, rings, length, k_facets));
  }
  void pin(const dvec3& tip, const dvec3& backward) {
    constexpr volume::TurnedRing k_rings[] = {{k_pin_cone, k_pin_radius}, {k_pin_length, k_pin_radius}};
    add(tip, backward, volume::turned_solid(0, k_rings, k_pin_length, k_facets));
  }
  std::shared_ptr<const haptics::MeshTree> finish() {
    return std::make_shared<const haptics::MeshTree>(std::move(vertices_), std::move(triangles_));
  }

 private:
  /// Adds a solid whose axis is turned from z to a unit direction.
  void add(const dvec3& from, const dvec3& along, const volume::TurnedSolid& solid) {
    const auto [u, v] = volume::perpendicular_axes(along);
    const auto first = static_cast<std::uint32_t>(vertices_.size());
    for (const dvec3& p : solid.vertices) vertices_.push_back(from + p.x * u + p.y * v + p.z * along);
    for (const std::uint32_t corner : solid.triangles) triangles_.push_back(first + corner);
  }

  std::vector<dvec3> vertices_;
  std::vector<std::uint32_t> triangles_;
};

}  // namespace

std::vector<ClampRod> clamp_rods(const ClampPose& pose, const Pins& tips_world, const dvec3& up_world,
                                 double arm_depth) {
  const Pins directions = pose.directions_world();
  Pins holders;
  for (std::size_t i = 0; i < k_pins; ++i) holders[i] = tips_world[i] - k_pin_length * directions[i];
  std::vector<ClampRod> rods{{holders[1], holders[2], k_rocker_radius}};
  dvec3 down = glm::cross(pose.axis_world, pose.across_world);
  if (glm::dot(down, up_world) > 0) down = -down;
  // The arms: half an ellipse from the holder of the single pin to the middle of the rocker.
  const dvec3 begin = holders[0], end = 0.5 * (holders[1] + holders[2]), middle = 0.5 * (begin + end);
  constexpr int k_parts = 12;
  dvec3 previous = begin;
  for (int i = 1; i <= k_parts; ++i) {
    const double angle = 3.141592653589793 * i / k_parts;
    const dvec3 next =
        middle + deterministic_cos(angle) * (begin - middle) + arm_depth * deterministic_sin(angle) * down;
    rods.push_back({previous, next, k_arm_radius});
    previous = next;
  }
  return rods;
}

std::shared_ptr<const haptics::MeshTree> clamp_surface(const ClampPose& pose, const Pins& tips_world,
                                                       const dvec3& up_world, double arm_depth) {
  Parts parts;
  const Pins directions = pose.directions_world();
  for (std::size_t i = 0; i < k_pins; ++i) parts.pin(tips_world[i], -directions[i]);
  for (const ClampRod& rod : clamp_rods(pose, tips_world, up_world, arm_depth))
    parts.rod(rod.from, rod.to, rod.radius);
  return parts.finish();
}

}  // namespace trephine::skull_clamp
