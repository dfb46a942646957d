#include "haptics/depth/lomi_proxy.h"

#include "haptics/depth/depth_items.h"
#include "haptics/depth/depth_rules.h"

namespace trephine::haptics {

using depth::DepthCube;
using glm::dvec3;

volume::Status LomiProxy::prepare(const TouchScene& scene) {
  if (volume::Status error = check_touchable(scene, false, true)) return error;
  if (volume::Status error = check_stays_whole(scene, name())) return error;
  const depth::Rates rates;
  options_.resolution = k_resolution;
  options_.voxels = depth::lomi_voxels(depth::lomi_size(rates), options_.resolution);
  auto cubes = depth::cubes_of(scene, {options_.resolution, options_.resolution});
  if (!cubes) return cubes.error();
  cubes_ = std::move(cubes).value();
  return std::nullopt;
}

ProxyStep LomiProxy::step(const TouchScene& scene, const TouchState& seen, ProxyState& state,
                          const ProxyInput& input) const noexcept {
  const volume::Frame& frame = seen.version->base().frame;
  ProxyStep result;
  result.normal_world = dvec3(0);
  const dvec3 hip = frame.volume_from_world(input.hip_world);
  if (!state.has_proxy) {
    begin_at_hip(hip, input.hip_world, state, result);
    return result;
  }
  int met = -1;  // the last item that a query was in
  const auto ask = [&](const dvec3& p, bool is_smooth) {
    for (int index = 0; index < item_count(scene); ++index) {
      if (!holds(scene, state.around.let_through, index, Side::front)) continue;
      const TouchItem& item = item_of(scene, index);
      const DepthCube& cube = cubes_[static_cast<std::size_t>(index)];
      const dvec3 local = item.is_mesh() ? item.placement.local_from_world(p) : p;
      const dvec3 at = cube.frame().volume_from_world(local);
      ++result.counters.cells;
      if (is_smooth ? cube.is_inside_smoothly(at, depth::Layers::outermost)
                    : cube.is_inside(at, depth::Layers::outermost)) {
        met = index;
        return true;
      }
    }
    return false;
  };
  const auto inside = [&](const dvec3& p) { return ask(p, false); };
  const auto inside_smoothly = [&](const dvec3& p) { return ask(p, true); };
  const dvec3 from = frame.world_from_volume(state.proxy_volume);
  // Where matter lies over the proxy nothing holds it. Nearest pixels and those between may tell two things.
  if (inside(from) && inside_smoothly(from)) {
    result.is_buried = state.had_contact;
    begin_at_hip(hip, input.hip_world, state, result);
    return result;
  }
  const depth::LomiRest rest = depth::find_rest(from, input.hip_world, options_, inside, inside_smoothly);
  result.counters.iterations = rest.asked;
  result.add_waypoint(state.proxy_volume);
  if (!rest.is_blocked) {
    result.add_waypoint(hip);
  } else {
    result.add_waypoint(frame.volume_from_world(rest.before));
    result.add_waypoint(frame.volume_from_world(rest.place));
    const dvec3 out = rest.place - input.hip_world;
    if (const double length = glm::length(out); length > 0 && met >= 0)
      result.set_contact(met, Side::front, out / length);
  }
  // Without friction: the normal is the way to the HIP, of which a cone would hold a proxy that lags for
  // ever.
  state.had_contact = result.has_contact;
  state.proxy_volume = result.path_volume[static_cast<std::size_t>(result.waypoint_count - 1)];
  result.proxy_world = frame.world_from_volume(state.proxy_volume);
  return result;
}

}  // namespace trephine::haptics
