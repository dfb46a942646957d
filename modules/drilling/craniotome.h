// A craniotome: a thin bit that cuts with its side, and a foot at its end that goes under the bone and keeps
// the bit off the dura.
#pragma once

#include "modules/drilling/burr.h"

namespace trephine::drilling {

struct Craniotome {
  double diameter = 2.3;       ///< mm, of the bit: the kerf's width
  double length = 14;          ///< mm, of the bit above the foot
  double foot = 5;             ///< mm, the foot's diameter
  double turning_radius = 10;  ///< mm, of the tightest curve that the foot lets it go
  double rpm = 70000;
  static const sim::Schema& schema();
};

/// It is touched with all of its bit; the hand holds the top of the foot.
struct CraniotomeState : BurrState {
  bool has_started = false, is_refused = false;  ///< since the button went down
  glm::dvec3 heading{0.0};                       ///< unit, the way of the last bites across the bit; 0: none
  static const sim::Schema& schema();
};

/// It does not start here: emitted once, when the button goes down.
struct CraniotomeRefused {
  std::string why;
  static const sim::Schema& schema();
};

sim::Instrument craniotome(const Craniotome& parameters);
const sim::InstrumentType& craniotome_type() noexcept;

}  // namespace trephine::drilling
