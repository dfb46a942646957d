#include "haptics/baselines/lomi_proxy.h"

#include "haptics/depth/depth_items.h"
#include "haptics/depth/depth_rules.h"

namespace trephine::haptics::baselines {

using depth::DepthCube;
using glm::dvec3;

Status LomiProxy::prepare(const TouchScene& scene) {
  if (Status error = check_touchable(scene, info())) return error;
  if (Status error = check_cuts(scene, info())) return error;
  const depth::Rates rates;
  options_.resolution = k_resolution;
  options_.voxels = depth::lomi_voxels(depth::lomi_size(rates), options_.resolution);
  auto cubes = depth::cubes_of(scene, {options_.resolution, options_.resolution});
  if (!cubes) return cubes.error();
  cubes_ = std::move(cubes).value();
  parts_.clear();
  if (objects_ == Objects::parts)
    for (const DepthCube& cube : cubes_) parts_.emplace_back(cube);
  return std::nullopt;
}

bool LomiProxy::is_inside(std::size_t item, const dvec3& p, bool is_smooth) const noexcept {
  const DepthCube& cube = cubes_[item];
  const dvec3 at = cube.frame().volume_from_world(p);
  if (objects_ == Objects::whole)
    return is_smooth ? cube.is_inside_smoothly(at, depth::Layers::outermost)
                     : cube.is_inside(at, depth::Layers::outermost);
  return is_smooth ? parts_[item].is_inside_smoothly(cube, at) : parts_[item].is_inside(cube, at);
}

ProxyStep LomiProxy::step(const TouchScene& scene, const TouchState& touch_state, ProxyState& state,
                          const ProxyInput& input) const noexcept {
  const volume::Frame& frame = touch_state.version->base().frame;
  ProxyStep result;
  result.normal_world = dvec3(0);
  const dvec3 hip = frame.volume_from_world(input.hip_world);
  if (!state.has_proxy) {
    begin_at_hip(hip, input.hip_world, state, result);
    return result;
  }
  int hit_item = -1;  // the item of the last query in matter
  const auto query = [&](const dvec3& p, bool is_smooth) {
    for (int index = 0; index < item_count(scene); ++index) {
      if (!blocks(scene, state.around.passable, index, Side::front)) continue;
      const TouchItem& item = item_of(scene, index);
      const dvec3 local = item.is_mesh() ? item.placement.local_from_world(p) : p;
      ++result.counters.cells;
      if (is_inside(static_cast<std::size_t>(index), local, is_smooth)) {
        hit_item = index;
        return true;
      }
    }
    return false;
  };
  const auto inside = [&](const dvec3& p) { return query(p, false); };
  const auto inside_smoothly = [&](const dvec3& p) { return query(p, true); };
  const dvec3 from = frame.world_from_volume(state.proxy_volume);
  // Look-ups by nearest pixels and smooth look-ups may disagree: matter requires both.
  const auto is_in_matter = [&](const dvec3& p) { return inside(p) && inside_smoothly(p); };
  // A proxy inside matter is released at the HIP.
  if (is_in_matter(from)) {
    result.is_buried = state.had_contact;
    begin_at_hip(hip, input.hip_world, state, result);
    return result;
  }
  const LomiRest rest = find_rest(from, input.hip_world, options_, inside, inside_smoothly);
  result.counters.iterations = rest.queries;
  result.add_waypoint(state.proxy_volume);
  if (!rest.is_blocked()) {
    result.add_waypoint(hip);
  } else {
    result.add_waypoint(frame.volume_from_world(rest.before));
    result.add_waypoint(frame.volume_from_world(rest.position));
    const dvec3 out = rest.position - input.hip_world;
    if (const double length = glm::length(out); length > 0 && hit_item >= 0)
      result.set_contact(hit_item, Side::front, out / length);
  }
  // A position halfway between two pixels may be in matter after rounding. The proxy then stays at its
  // previous position.
  if (is_in_matter(
          frame.world_from_volume(result.path_volume[static_cast<std::size_t>(result.waypoint_count - 1)])))
    result.waypoint_count = 1;
  const bool is_rubbing = result.has_contact && state.had_contact;
  state.had_contact = result.has_contact;
  state.proxy_volume = result.path_volume[static_cast<std::size_t>(result.waypoint_count - 1)];
  result.proxy_world = frame.world_from_volume(state.proxy_volume);
  // Friction moves the end of the spring from the final position toward the temporary position, at which the
  // motion met the surface. The next search begins at the final position, so that friction does not hold a
  // resting hand.
  if (is_rubbing) {
    const Material& material = material_of(scene, result.shape, result.side);
    const dvec3 slid = rest.before - rest.position;
    const double max_slide = material.dynamic_friction * glm::distance(rest.position, input.hip_world);
    const double length = glm::length(slid);
    if (length > 0) result.proxy_world += std::min(1.0, max_slide / length) * slid;
  }
  return result;
}

}  // namespace trephine::haptics::baselines
