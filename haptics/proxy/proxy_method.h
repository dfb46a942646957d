// ProxyMethod: interface of all contact methods.
#pragma once

#include "haptics/proxy/proxy_step.h"
#include "haptics/scene/touch_state.h"

namespace trephine::haptics {

/// Checks the requirement of most methods: at most k_max_shapes shapes of one volume, each with its bits.
/// Also an error for a tool with a radius, or meshes, unless the method supports them.
Status check_touchable(const TouchScene& scene, bool has_radius = false, bool has_meshes = false);
/// For methods that lead a point only into cuts at least `min_mm` wide: error if the scene allows smaller
/// burrs.
Status check_smallest_burr(const TouchScene& scene, double min_mm);
/// For methods on the voxels of the scan: error if a burr may be narrower than the diagonal of a voxel, since
/// its hole could then pass between voxel centres.
Status check_burr_opens_voxels(const TouchScene& scene);
/// For methods that touch only the untouched volume: error if the scene allows cuts.
Status check_stays_whole(const TouchScene& scene, const char* method);
/// For methods with fixed models: error if an item is touched by depth images.
Status check_has_no_depth(const TouchScene& scene);
/// Checks that a scene with a tool radius has the offset fields for it. Also an error for a tool of several
/// balls, unless the method supports it.
Status check_offsets(const TouchScene& scene, bool has_balls = false);

class ProxyMethod {
 public:
  virtual ~ProxyMethod() = default;
  virtual const char* name() const noexcept = 0;
  /// Allocates all that step() needs. Not for the servo thread.
  virtual Status prepare(const TouchScene& scene) = 0;
  /// Runs one servo step on one immutable state. Servo thread: no allocation, lock or exception; iterations
  /// are bounded.
  virtual ProxyStep step(const TouchScene& scene, const TouchState& touch_state, ProxyState& state,
                         const ProxyInput& input) const noexcept = 0;
};

}  // namespace trephine::haptics
