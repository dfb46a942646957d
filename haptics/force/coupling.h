// Coupling: spring and damper from the hand to a virtual tool, and stiffness limits of devices.
#pragma once

#include "haptics/device/device.h"
#include "haptics/force/force.h"

namespace trephine::haptics {

/// 1 N accelerates 1 kg by this value, mm/s2.
inline constexpr double k_mm_s2_per_n_kg = 1000;

/// Spring and damper.
struct Coupling {
  double stiffness = 0;  ///< N/mm
  double damping = 0;    ///< N s/mm
};

/// Returns the stiffest critically damped coupling of a mass (kg) that a device with `device_damping` (N
/// s/mm) renders passively at a rate: B = 2 sqrt(K m / 1000) and b >= K T / 2 + B (after Colgate and Schenkel
/// 1997), with the device's damping b and the period T.
Coupling critical_coupling(double mass, double device_damping, double rate_hz);

/// Returns the largest stiffness (N/mm) of a surface of damping B (N s/mm) that a device renders passively
/// for any hand: K = 2 (b - B) / T (Colgate and Schenkel 1997), with b and T as above. 0 if B exceeds b.
double passive_stiffness(double device_damping, double surface_damping, double rate_hz);

/// Returns the options limited by the device's capabilities, with the damping of the device; unknown
/// capabilities change nothing.
ForceOptions within_limits(const ForceOptions& options, const DeviceCapabilities& device);
/// Returns the material with its stiffness limited to what the device can render.
Material within_limits(const Material& material, const DeviceCapabilities& device);

}  // namespace trephine::haptics
