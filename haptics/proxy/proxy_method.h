// ProxyMethod: interface of all contact methods.
#pragma once

#include "haptics/proxy/method_info.h"
#include "haptics/proxy/proxy_step.h"
#include "haptics/scene/touch_state.h"

namespace trephine::haptics {

/// Checks the requirements of most methods: at most k_max_shapes shapes of one volume, each with its
/// occupancy, and no depth images. Also an error if the method does not take the tool, or the meshes of the
/// scene.
Status check_touchable(const TouchScene& scene, const MethodInfo& method);
/// For methods with which a point tool enters only cuts at least `min_mm` wide: error if the scene allows
/// smaller burrs.
Status check_smallest_burr(const TouchScene& scene, double min_mm);
/// For methods on the voxels of the scan: error if a burr may be narrower than the diagonal of a voxel, since
/// its hole could then pass between voxel centres.
Status check_burr_opens_voxels(const TouchScene& scene);
/// Error if the scene is prepared for burrs (TouchScene::smallest_burr) and the method takes no cuts.
Status check_cuts(const TouchScene& scene, const MethodInfo& method);
/// For methods with fixed models: error if an item is touched by depth images.
Status check_has_no_depth(const TouchScene& scene);
/// Checks that a scene with a tool radius has the offset fields for it. Also an error if the method does not
/// take the tool.
Status check_offsets(const TouchScene& scene, const MethodInfo& method);

class ProxyMethod {
 public:
  virtual ~ProxyMethod() = default;
  virtual const MethodInfo& info() const noexcept = 0;
  const char* name() const noexcept { return info().name; }
  /// Allocates all that step() needs. Not for the servo thread.
  virtual Status prepare(const TouchScene& scene) = 0;
  /// Runs one servo step on one immutable state. Servo thread: no allocation, lock or exception; iterations
  /// are bounded.
  virtual ProxyStep step(const TouchScene& scene, const TouchState& touch_state, ProxyState& state,
                         const ProxyInput& input) const noexcept = 0;
};

}  // namespace trephine::haptics
