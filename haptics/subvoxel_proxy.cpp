#include "haptics/subvoxel_proxy.h"

#include "haptics/slide.h"

namespace trephine::haptics {

using glm::dvec3;

volume::Status SubvoxelProxy::prepare(const TouchScene& scene) { return check_touchable(scene, true); }

ProxyStep SubvoxelProxy::step(const TouchScene& scene, const volume::Version& version, ProxyState& state,
                              const ProxyInput& input) const noexcept {
  ProxyStep result;
  result.normal_world = dvec3(0);
  SmoothWalls walls(scene, version, state.around.let_through, result.counters);
  Slide(scene, walls, version.base().frame, state, input.hip_world, result).run();
  return result;
}

}  // namespace trephine::haptics
