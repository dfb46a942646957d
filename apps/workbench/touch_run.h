// play_touch: runs a path over a touchable scene, with a callback for every tick.
#pragma once

#include "apps/workbench/operation.h"
#include "sim/session/session_writer.h"

namespace trephine::workbench {

struct TouchTick {
  double t = 0;                          ///< s
  const haptics::ServoRecord& record;    ///< input and output of the tick
  const haptics::ServoCore& servo;       ///< servo of the hand after the tick
  const haptics::ServoHand& servo_hand;  ///< touchable data of the hand in the tick
  double step_us = 0;                    ///< duration of the servo's step, us
};
using TouchObserver = std::function<void(const TouchTick& tick)>;

/// Moves one hand along a path, without threads. `recorder` may be null. It records every tick; the caller
/// must finish it. Returns the final engine. Stops before the end of the path if the listener cancels.
sim::Engine play_touch(const Operation& operation, const haptics::PosePath& path,
                       sim::SessionWriter* recorder, const TouchObserver& observer,
                       const Listener& listener = {});

}  // namespace trephine::workbench
