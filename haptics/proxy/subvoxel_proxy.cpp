#include "haptics/proxy/subvoxel_proxy.h"

#include "haptics/proxy/slide.h"

namespace trephine::haptics {

using glm::dvec3;

Status SubvoxelProxy::prepare(const TouchScene& scene) { return check_touchable(scene, info()); }

ProxyStep SubvoxelProxy::step(const TouchScene& scene, const TouchState& touch_state, ProxyState& state,
                              const ProxyInput& input) const noexcept {
  ProxyStep result;
  result.normal_world = dvec3(0);
  SmoothWalls walls(scene, touch_state, state.around.passable, result.counters, 0, item_count(scene),
                    nullptr);
  slide(scene, walls, touch_state.version->base().frame, state, input.hip_world, result);
  return result;
}

}  // namespace trephine::haptics
