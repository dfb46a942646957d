#include "haptics/proxy/layer_contact.h"

#include <algorithm>
#include <cmath>

namespace trephine::haptics {

using glm::dvec3;

namespace {
constexpr int k_steps = 4;            // of Newton's method toward the surface
constexpr double k_converged = 0.02;  // of the layer; a shorter step ends the search
constexpr double k_margin = 2;        // layers; a node of the tree within this distance is not skipped
}  // namespace

/// Returns the depth of p below the surface on which the function of the wall is 0, along its gradient.
LayerContact::Depth LayerContact::depth_below(SmoothWalls& walls, const Wall& wall,
                                              const dvec3& p) const noexcept {
  const volume::Frame& frame = walls.frame();
  Depth depth;
  dvec3 q = p;
  double step = 0, sign = 1;
  for (int i = 0; i < k_steps; ++i) {
    const volume::ValueAndGradient field = walls.value_and_gradient(wall, q);
    const dvec3 gradient = frame.gradient_world_from_volume(field.gradient);
    const double square = glm::dot(gradient, gradient);
    if (i == 0) {
      depth.region = field.value < 0 ? Region::outside : Region::interior;
      sign = field.value < 0 ? -1 : 1;
    }
    // This comparison also holds for a gradient of 0.
    const double most = field.value < 0 ? k_margin * options_.layer_mm : options_.deepest_mm;
    if (!(field.value * field.value < most * most * square)) return depth;
    const double steepness = std::sqrt(square);
    step = field.value / steepness;
    q -= frame.vector_volume_from_world((step / steepness) * gradient);
    depth.outward = (-1 / steepness) * gradient;
    if (std::abs(step) < k_converged * options_.layer_mm) break;
  }
  if (!(std::abs(step) < 0.1 * options_.layer_mm)) return depth;  // there is no surface near p
  depth.mm = sign * glm::length(frame.vector_world_from_volume(p - q));
  depth.region = depth.mm > options_.deepest_mm  ? Region::interior
                 : depth.mm > -options_.layer_mm ? Region::layer
                                                 : Region::outside;
  return depth;
}

/// Returns the depth of p in the shape less its cuts.
LayerContact::Depth LayerContact::depth_in(SmoothWalls& walls, int shape, const dvec3& p) const noexcept {
  const Depth field = depth_below(walls, {shape, false, false}, p);
  if (field.region == Region::outside || !walls.is_near_cut(volume::voxel_of(p))) return field;
  const Depth cut = depth_below(walls, {shape, true, false}, p);
  if (field.region == Region::interior) return cut;
  return cut.region == Region::outside || (cut.region == Region::layer && cut.mm < field.mm) ? cut : field;
}

PoseForce LayerContact::contact(const Placement& tool, bool uses_tree) const noexcept {
  PoseForce result;
  ProxyCounters counters;
  const ShapeSet passable;
  SmoothWalls::LargeCache cache;
  SmoothWalls walls(scene_, state_, passable, counters);
  walls.use(cache);
  const volume::Frame& frame = walls.frame();
  const dvec3 spacing = frame.spacing();
  const double finest = std::min({spacing.x, spacing.y, spacing.z}), margin = k_margin * options_.layer_mm;
  const glm::dmat3 rotation = glm::mat3_cast(tool.rotation);
  const auto is_free_within = [&](const dvec3& p, double mm) {
    for (int s = walls.next_shape(0); s < ShapeSet::k_max; s = walls.next_shape(s + 1))
      if (!walls.is_free_within(s, p, mm / finest, mm) && !walls.is_air_within(s, p, mm / finest))
        return false;
    return true;
  };
  dvec3 force(0), torque(0);
  const auto use_point = [&](std::uint32_t i) {
    ++result.tests;
    const PointShell::Point& point = shell_.points()[i];
    const dvec3 arm = rotation * point.position, p = frame.volume_from_world(tool.position_world + arm);
    Depth deepest;
    for (int s = walls.next_shape(0); s < ShapeSet::k_max; s = walls.next_shape(s + 1)) {
      if (!walls.blocks(s, Side::front)) continue;
      const Depth depth = depth_in(walls, s, p);
      if (depth.region > deepest.region || (depth.region == deepest.region && depth.mm > deepest.mm))
        deepest = depth;
    }
    if (deepest.region == Region::interior) ++result.interior;
    if (deepest.region != Region::layer) return true;
    ++result.points;
    const dvec3 push = (point.area * pressure(deepest.mm)) * deepest.outward;
    force += push;
    torque += glm::cross(arm, push);
    return true;
  };
  if (uses_tree) {
    shell_.visit(
        [&](const PointShell::Node& node) {
          ++result.tests;
          return is_free_within(frame.volume_from_world(tool.position_world + rotation * node.centre),
                                node.radius + margin);
        },
        use_point);
  } else {
    for (std::uint32_t i = 0; i < shell_.points().size(); ++i) use_point(i);
  }
  result.set(force, torque);
  return result;
}

}  // namespace trephine::haptics
