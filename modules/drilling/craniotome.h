// Craniotome: a thin bit that cuts with its side, and a foot at its end that slides below the bone and keeps
// the bit off the dura.
#pragma once

#include "modules/drilling/burr.h"

namespace trephine::drilling {

struct Craniotome {
  double diameter = 2.3;       ///< mm, of the bit: width of the kerf
  double length = 14;          ///< mm, of the bit above the foot
  double foot = 5;             ///< mm, diameter of the foot
  double turning_radius = 10;  ///< mm, of the tightest curve that the foot allows
  double rpm = 70000;          ///< 1/min
  static const sim::Schema& schema();
};

/// State of a craniotome. The bit and the rim of the foot touch. The position of the hand is that of the top
/// of the foot.
struct CraniotomeState : BurrState {
  bool has_started = false, is_refused = false;  ///< since the button was pressed
  glm::dvec3 heading{0.0};                       ///< unit, direction of the cut, across the bit; 0: not set
  static const sim::Schema& schema();
};

/// The craniotome cannot start here. Emitted once per press of the button.
struct CraniotomeRefused {
  std::string reason;
  static const sim::Schema& schema();
};

sim::Instrument craniotome(const Craniotome& parameters);
const sim::InstrumentType& craniotome_type() noexcept;

}  // namespace trephine::drilling
