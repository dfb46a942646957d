#include "haptics/barrier.h"

#include "haptics/friction.h"

namespace trephine::haptics {

namespace {

/// The shapes in whose solid p lies.
ShapeSet solids_at(const TouchScene& scene, const volume::Version& version, const glm::dvec3& p) noexcept {
  const glm::ivec3 v = volume::voxel_of(p);
  ShapeSet found;
  for (std::size_t s = 0; s < scene.shapes.size(); ++s)
    if (is_solid(scene, version, s, v)) found.set(static_cast<int>(s), true);
  return found;
}

}  // namespace

bool begin_on_cubes(const TouchScene& scene, const volume::Version& version, const glm::dvec3& hip,
                    ProxyState& state, ProxyStep& result) noexcept {
  bool is_fresh = !state.has_proxy;
  if (!is_fresh) {
    const glm::ivec3 v = volume::voxel_of(state.proxy_volume);
    for (std::size_t s = 0; s < scene.shapes.size(); ++s) {
      const bool was = state.inside.contains(static_cast<int>(s));
      if (is_solid(scene, version, s, v) != was &&
          holds(scene, state.around.let_through, static_cast<int>(s), side_of(was)))
        result.is_buried = is_fresh = true;
    }
  }
  if (!is_fresh) return false;
  state.begin_at(hip);
  state.inside = solids_at(scene, version, hip);
  result.path_volume[0] = hip;
  result.waypoint_count = 1;
  return true;
}

void end_on_cubes(const TouchScene& scene, const volume::Version& version, const glm::dvec3& hip_world,
                  int landing, ProxyState& state, ProxyStep& result) noexcept {
  const auto is_blocked = [&](const glm::dvec3& a, const glm::dvec3& b) {
    ShapeSet after = state.inside;
    return find_barrier(scene, version, a, b, state.around.let_through, after, result.counters).is_blocked;
  };
  end_with_friction(version.base().frame, scene, hip_world, landing, is_blocked, state, result);
  state.inside = solids_at(scene, version, state.proxy_volume);
}

}  // namespace trephine::haptics
