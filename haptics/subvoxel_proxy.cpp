#include "haptics/subvoxel_proxy.h"

#include "haptics/slide.h"

namespace trephine::haptics {

using glm::dvec3;

volume::Status SubvoxelProxy::prepare(const TouchScene& scene) {
  if (volume::Status error = check_touchable(scene, true)) return error;
  if (scene.tool_radius > 0)
    for (const TouchShape& shape : scene.shapes)
      if (!shape.offset || shape.offset->radius_mm() != scene.tool_radius)
        return volume::Error{"a shape has no offset field for the tool's radius", shape.field.shape().name,
                             "", "", "set_tool_radius() makes it"};
  return std::nullopt;
}

ProxyStep SubvoxelProxy::step(const TouchScene& scene, const volume::Version& version, ProxyState& state,
                              const ProxyInput& input) const noexcept {
  ProxyStep result;
  result.normal_world = dvec3(0);
  SmoothWalls walls(scene, version, state.around.let_through, result.counters);
  Slide(scene, walls, version.base().frame, state, input.hip_world, result).run();
  return result;
}

}  // namespace trephine::haptics
