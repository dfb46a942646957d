#include "modules/skull_clamp/clamp_surface.h"

#include <cmath>
#include <glm/geometric.hpp>
#include <span>
#include <vector>

#include "volume/base/deterministic_math.h"

namespace trephine::skull_clamp {

using glm::dvec3;

namespace {

// Sizes in mm, assumed: they serve the display.
constexpr double k_pin_cone = 6, k_pin_radius = 3, k_pin_length = 40;
constexpr double k_arm_radius = 8, k_rocker_radius = 6, k_arm_depth = 130;
constexpr int k_facets = 10;

/// A circle about the axis of a turned solid.
struct Ring {
  double along, radius;
};

/// Collects turned solids: closed surfaces about straight axes.
class Lathe {
 public:
  /// Adds the solid from `from` along a unit direction, through the rings; both ends are on the axis.
  void turn(const dvec3& from, const dvec3& along, std::span<const Ring> rings, double end) {
    const dvec3 aside = std::abs(along.x) < 0.6 ? dvec3(1, 0, 0) : dvec3(0, 1, 0);
    const dvec3 u = glm::normalize(glm::cross(along, aside)), v = glm::cross(along, u);
    const auto first = static_cast<std::uint32_t>(vertices_.size());
    for (const Ring& ring : rings)
      for (int i = 0; i < k_facets; ++i) {
        const double angle = 6.283185307179586 * i / k_facets;
        vertices_.push_back(from + ring.along * along +
                            ring.radius * (deterministic_cos(angle) * u + deterministic_sin(angle) * v));
      }
    const auto low = static_cast<std::uint32_t>(vertices_.size()), high = low + 1;
    vertices_.push_back(from), vertices_.push_back(from + end * along);
    const auto count = static_cast<std::uint32_t>(rings.size());
    constexpr auto k_ring = static_cast<std::uint32_t>(k_facets);
    const auto add = [this](std::uint32_t a, std::uint32_t b, std::uint32_t c) {
      triangles_.insert(triangles_.end(), {a, b, c});
    };
    for (std::uint32_t i = 0; i < k_ring; ++i) {
      const std::uint32_t j = (i + 1) % k_ring;
      add(low, first + j, first + i);
      for (std::uint32_t r = 0; r + 1 < count; ++r) {
        const std::uint32_t a = first + r * k_ring, b = a + k_ring;
        add(a + i, a + j, b + i), add(a + j, b + j, b + i);
      }
      add(first + (count - 1) * k_ring + i, first + (count - 1) * k_ring + j, high);
    }
  }
  void rod(const dvec3& from, const dvec3& to, double radius) {
    const double length = glm::distance(from, to);
    if (!(length > 0)) return;
    const std::array<Ring, 2> rings{Ring{0, radius}, Ring{length, radius}};
    turn(from, (to - from) / length, rings, length);
  }
  void pin(const dvec3& tip, const dvec3& backward) {
    const std::array<Ring, 2> rings{Ring{k_pin_cone, k_pin_radius}, Ring{k_pin_length, k_pin_radius}};
    turn(tip, backward, rings, k_pin_length);
  }
  std::shared_ptr<const haptics::MeshTree> finish() {
    return std::make_shared<const haptics::MeshTree>(std::move(vertices_), std::move(triangles_));
  }

 private:
  std::vector<dvec3> vertices_;
  std::vector<std::uint32_t> triangles_;
};

}  // namespace

std::shared_ptr<const haptics::MeshTree> clamp_surface(const ClampPose& pose, const Pins& tips_world,
                                                       const dvec3& up_world) {
  Lathe lathe;
  const Pins directions = pose.directions_world();
  Pins holders;
  for (std::size_t i = 0; i < k_pins; ++i) {
    lathe.pin(tips_world[i], -directions[i]);
    holders[i] = tips_world[i] - k_pin_length * directions[i];
  }
  lathe.rod(holders[1], holders[2], k_rocker_radius);
  // The arms: half an ellipse below the head, from the single pin's holder to the rocker's.
  dvec3 down = glm::cross(pose.axis_world, pose.across_world);
  if (glm::dot(down, up_world) > 0) down = -down;
  const dvec3 begin = holders[0], end = 0.5 * (holders[1] + holders[2]), middle = 0.5 * (begin + end);
  constexpr int k_parts = 12;
  dvec3 previous = begin;
  for (int i = 1; i <= k_parts; ++i) {
    const double angle = 3.141592653589793 * i / k_parts;
    const dvec3 next =
        middle + deterministic_cos(angle) * (begin - middle) + k_arm_depth * deterministic_sin(angle) * down;
    lathe.rod(previous, next, k_arm_radius);
    previous = next;
  }
  return lathe.finish();
}

}  // namespace trephine::skull_clamp
