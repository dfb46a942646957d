// RaystepProxy, PlaneProxy, GradientProxy: older contact methods, implemented with their faults as baselines.
#pragma once

#include "haptics/proxy/proxy_method.h"

namespace trephine::haptics::baselines {

/// Samples the motion in steps of k = 0.1 mm (delta = k / |end - start|). Each sample looks up the nearest
/// voxel in a binary transfer function. The normal is the central difference at that voxel, negated on the
/// back. The proxy continues in the tangent plane at the contact ("Haptic Interaction with Volumetric
/// Datasets Using Surface-based Haptic Libraries", 3.2 - 3.4). Passes thin matter between two steps, and
/// matter under the tangent plane. Cost: proportional to speed.
class RaystepProxy final : public ProxyMethod {
 public:
  static constexpr double k_step = 0.1;  ///< mm
  static constexpr MethodInfo k_info{
      .name = "raystep",
      .meaning = "fixed steps along the motion, nearest voxels, binary transfer functions",
      .source = "Rizzi, Luciano and Banerjee 2010",
      .solid = MethodInfo::Solid::nothing};
  const MethodInfo& info() const noexcept override { return k_info; }
  Status prepare(const TouchScene& scene) override;
  ProxyStep step(const TouchScene& scene, const TouchState& touch_state, ProxyState& state,
                 const ProxyInput& input) const noexcept override;
};

/// Intermediate representation (Adachi, Kumano and Ogino 1995): a tangent plane found once per
/// k_ticks_per_plane ticks and touched in between; a new plane is approached over k_recovery ticks (recovery
/// time, Mark et al. 1996). Misses solids thinner than the motion between two planes.
class PlaneProxy final : public ProxyMethod {
 public:
  static constexpr int k_ticks_per_plane = 10;
  static constexpr int k_recovery = 5;  ///< ticks
  static constexpr MethodInfo k_info{.name = "plane",
                                     .meaning = "a tangent plane, found at a tenth of the rate",
                                     .source = "Adachi, Kumano and Ogino 1995; Mark et al. 1996",
                                     .solid = MethodInfo::Solid::nothing};
  const MethodInfo& info() const noexcept override { return k_info; }
  Status prepare(const TouchScene& scene) override;
  ProxyStep step(const TouchScene& scene, const TouchState& touch_state, ProxyState& state,
                 const ProxyInput& input) const noexcept override;
};

/// Force field without a proxy: depth is the value over the slope of the field, direction is its gradient
/// (Avila and Sobierajski 1996). Keeps no state between ticks, so that the tool pops through thin solids and
/// the force jumps at ridges.
class GradientProxy final : public ProxyMethod {
 public:
  static constexpr MethodInfo k_info{.name = "gradient",
                                     .meaning = "a force field without a proxy",
                                     .source = "Avila and Sobierajski 1996",
                                     .solid = MethodInfo::Solid::nothing};
  const MethodInfo& info() const noexcept override { return k_info; }
  Status prepare(const TouchScene& scene) override;
  ProxyStep step(const TouchScene& scene, const TouchState& touch_state, ProxyState& state,
                 const ProxyInput& input) const noexcept override;
};

}  // namespace trephine::haptics::baselines
