#include "haptics/proxy/subvoxel_proxy.h"

#include "haptics/proxy/slide.h"

namespace trephine::haptics {

using glm::dvec3;

volume::Status SubvoxelProxy::prepare(const TouchScene& scene) { return check_touchable(scene, true); }

ProxyStep SubvoxelProxy::step(const TouchScene& scene, const TouchState& seen, ProxyState& state,
                              const ProxyInput& input) const noexcept {
  ProxyStep result;
  result.normal_world = dvec3(0);
  SmoothWalls walls(scene, seen, state.around.let_through, result.counters, 0, item_count(scene), nullptr);
  slide(scene, walls, seen.version->base().frame, state, input.hip_world, result);
  return result;
}

}  // namespace trephine::haptics
