// A cranial perforator: an inner drill leads an outer one, and a clutch stops both when the inner one meets
// no bone any more.
#pragma once

#include "modules/drilling/burr.h"

namespace trephine::drilling {

struct Perforator {
  double diameter = 14;  ///< mm, of the outer drill
  double inner = 11;     ///< mm, of the inner one, which is round at its end
  double lead = 3;       ///< mm that it is ahead
  double feed = 0.2;     ///< mm/s for each newton of press
  double engages = 0.5;  ///< N of press that the clutch needs to hold
  static const sim::Schema& schema();
};

/// It is touched with the ball of its inner drill, whose middle the hand holds.
struct PerforatorState : BurrState {
  bool has_begun = false;     ///< since the button went down
  bool has_stopped = false;   ///< and stays so until the button is let go
  glm::dvec3 begun_tip{0.0};  ///< where its tip was then
  static const sim::Schema& schema();
};

/// The clutch let go: emitted where its tip was.
struct PerforatorStopped {
  double depth = 0;  ///< mm of bone that it went through
  static const sim::Schema& schema();
};

sim::Instrument perforator(const Perforator& parameters);
const sim::InstrumentType& perforator_type() noexcept;

}  // namespace trephine::drilling
