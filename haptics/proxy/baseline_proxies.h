// The older ways to touch a volume, kept honest, faults and all: yardsticks for the others.
#pragma once

#include "haptics/proxy/proxy_method.h"

namespace trephine::haptics {

/// Fixed steps of k = 0.1 mm along the way (delta = k / |end - start|), the nearest voxel at each looked up
/// in binary transfer functions; the normal by central differences at the voxel, turned round on the back;
/// the proxy goes on in the tangent plane at the contact ("Haptic Interaction with Volumetric
/// Datasets Using Surface-based Haptic Libraries", 3.2 - 3.4). Thin matter between two steps, and what lies
/// under the tangent plane, is passed. Cost: proportional to speed.
class RaystepProxy final : public ProxyMethod {
 public:
  static constexpr double k_step = 0.1;  ///< mm
  const char* name() const noexcept override { return "raystep"; }
  volume::Status prepare(const TouchScene& scene) override;
  ProxyStep step(const TouchScene& scene, const TouchState& seen, ProxyState& state,
                 const ProxyInput& input) const noexcept override;
};

/// Intermediate representation (Adachi, Kumano and Ogino 1995): a tangent plane found at one in
/// k_ticks_a_plane ticks and touched in between; a new plane is approached over k_recovery ticks (recovery
/// time, Mark et al. 1996). Solids thinner than the motion between two planes are missed.
class PlaneProxy final : public ProxyMethod {
 public:
  static constexpr int k_ticks_a_plane = 10;
  static constexpr int k_recovery = 5;
  const char* name() const noexcept override { return "plane"; }
  volume::Status prepare(const TouchScene& scene) override;
  ProxyStep step(const TouchScene& scene, const TouchState& seen, ProxyState& state,
                 const ProxyInput& input) const noexcept override;
};

/// A force field without a proxy: depth by the value over the slope of the field, direction by its gradient
/// (Avila and Sobierajski 1996). Keeps nothing from tick to tick, so thin solids are popped through and the
/// force jumps at ridges.
class GradientProxy final : public ProxyMethod {
 public:
  const char* name() const noexcept override { return "gradient"; }
  volume::Status prepare(const TouchScene& scene) override;
  ProxyStep step(const TouchScene& scene, const TouchState& seen, ProxyState& state,
                 const ProxyInput& input) const noexcept override;
};

}  // namespace trephine::haptics
