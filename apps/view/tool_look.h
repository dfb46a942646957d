// How a tool is drawn and changed by a window that knows none: by the table of its parameters.
#pragma once

#include "sim/value.h"

namespace trephine::view {

/// mm: half of its field "diameter"; 0 when it has none, which is drawn as a fine tip.
double drawn_radius(const sim::Value& parameters);
/// Its first number a step up or down, within its range: 0.5 of its unit. False when it has none.
bool step_first_number(sim::Value& parameters, int steps);

}  // namespace trephine::view
