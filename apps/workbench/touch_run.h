// Run of a path over a touchable scene, with a callback for every tick.
#pragma once

#include "apps/workbench/operation.h"
#include "sim/session_writer.h"

namespace trephine::workbench {

struct TouchTick {
  double t = 0;                          ///< s
  const haptics::ServoRecord& record;    ///< input and output
  const haptics::ServoCore& servo;       ///< after it
  const haptics::ServoHand& servo_hand;  ///< its scene
  double step_us = 0;                    ///< what the servo's step took
};
using TouchObserver = std::function<void(const TouchTick& tick)>;

/// Runs one hand, without threads. `recorder` may be null; it records every tick, and is not finished. Gives
/// the engine as it ended, before the path's end when the listener stopped it.
sim::Engine play_touch(const Operation& operation, const haptics::PosePath& path,
                       sim::SessionWriter* recorder, const TouchObserver& observer,
                       const Listener& listener = {});

}  // namespace trephine::workbench
