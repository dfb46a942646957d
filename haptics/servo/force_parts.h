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
    transition,  ///< limit while the proxy is led out of restored matter, or an item becomes ready
    effect,      ///< one effect of the hand or of its instrument
    power,       ///< limit of the power of effects that may create energy
    energy,      ///< limit by the passivity controller
    limits,      ///< final limits of size, change and fade
  } kind = Kind::spring;
  std::string name;  ///< "spring"; of an effect its definition, such as "constant force=0,0,1 most=3"
  Wrench wrench;     ///< N, N mm; world
};

struct ForceParts {
  ServoRecord record;
  ProxyStep step;                ///< result of the contact method
  double stiffness = 0;          ///< N/mm; 0 without contact
  Material material;             ///< of the touched item; valid with contact
  std::vector<ForcePart> parts;  ///< above 1e-9 N or N mm; their sum is the wrench of the record

  /// Length of the spring along the surface over that along the normal; the proxy slides where it reaches the
  /// friction coefficient. 0 without contact.
  double friction_ratio() const noexcept;
};

/// Repeats a tick from the state before it. Each part is the difference that the tick has without it. Not for
/// the servo thread.
ForceParts force_parts(const ServoCore& before, const ServoScene& scene, const ServoInput& input);

}  // namespace trephine::haptics
