// ForceParts: the force of one tick as the sum of its parts, to explain a perceived force.
#pragma once

#include <string>
#include <vector>

#include "haptics/servo/servo_core.h"

namespace trephine::haptics {

/// One addend of the force and the torque of a tick.
struct ForcePart {
  enum class Kind {
    spring,      ///< stiffness times the distance from the hand to the proxy
    damping,     ///< damping and viscosity of the material
    smoothing,   ///< difference between the smoothed and the newest force of the surface
    transition,  ///< lower force limit during and after an escape, or while depth images are overdue
    effect,      ///< one effect of the hand or of its instrument
    power,       ///< limit of the power of effects that may create energy
    energy,      ///< limit by the passivity controller
    limits,      ///< final limits of magnitude and slew, and the fade after a fault
  } kind = Kind::spring;
  std::string name;  ///< "spring"; for an effect its definition: "constant force=0,0,1 most=3"
  Wrench wrench;     ///< N, N mm; world
};

struct ForceParts {
  ServoRecord record;
  ProxyStep step;        ///< result of the contact method
  double stiffness = 0;  ///< N/mm; 0 without contact
  Material material;     ///< of the touched item; valid with contact
  /// Their sum is the wrench of the record. Parts below 1e-9 N and N mm are omitted.
  std::vector<ForcePart> parts;

  /// Returns the length of the spring along the surface, divided by its length along the normal. The proxy
  /// slides when this ratio reaches the friction coefficient. 0 without contact.
  double friction_ratio() const noexcept;
};

/// Runs a tick again, from the state `before` it, and splits its wrench into parts. The part of an effect is
/// the change of the requested wrench when this effect is removed. Not for the servo thread.
ForceParts force_parts(const ServoCore& before, const ServoScene& scene, const ServoInput& input);

}  // namespace trephine::haptics
