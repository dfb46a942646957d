// Perforator: a cranial drill with an inner drill that leads an outer one, and a clutch that stops both when
// the inner one leaves the bone.
#pragma once

#include "modules/drilling/burr.h"

namespace trephine::drilling {

struct Perforator {
  double diameter = 14;       ///< mm, of the outer drill
  double inner = 11;          ///< mm, of the inner drill, which has a round end
  double lead = 3;            ///< mm by which the inner drill is ahead
  double feed = 0.2;          ///< mm/s per newton of contact force
  double engage_force = 0.5;  ///< N, contact force above which the clutch engages
  static const sim::Schema& schema();
};

/// State of a perforator. The ball of the inner drill touches. The position of the hand is that of the centre
/// of this ball.
struct PerforatorState : BurrState {
  bool has_begun = false;     ///< bone was cut since the button was pressed
  bool has_stopped = false;   ///< the clutch released; true until the button is released
  glm::dvec3 begun_tip{0.0};  ///< mm, outer end of the hole, on the axis of the drill
  static const sim::Schema& schema();
};

/// The clutch released. Emitted at the position of the tip.
struct PerforatorStopped {
  double depth = 0;       ///< mm, depth of the hole in bone
  bool was_open = false;  ///< the hole was through the bone before: the clutch did not engage
  static const sim::Schema& schema();
};

sim::Instrument perforator(const Perforator& parameters);
const sim::InstrumentType& perforator_type() noexcept;

}  // namespace trephine::drilling
