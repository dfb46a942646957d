// What an instrument does to the volume at each tick of the servo.
#pragma once

#include "haptics/servo_loop.h"
#include "volume/removal.h"

namespace trephine::sim {

/// Called on the edit thread (or in lockstep), once for every servo tick of a stroke, in order.
class Tool {
 public:
  virtual ~Tool() = default;
  /// Edits what the instrument takes away in the `dt` seconds of this tick.
  virtual volume::RemovalReport apply(const haptics::ServoRecord& tick, double dt,
                                      volume::RemovalEditor& editor) = 0;
  /// The stroke is over: the next tick starts afresh.
  virtual void lift() = 0;
};

}  // namespace trephine::sim
