// What an instrument does to the volume at each tick of the servo.
#pragma once

#include <string_view>

#include "haptics/servo/servo_core.h"
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
  /// Sets one of the instrument's settings by the name that recordings use; false when it has no such setting
  /// or the value is out of range. Between strokes.
  virtual bool set(std::string_view name, double value) = 0;
};

}  // namespace trephine::sim
