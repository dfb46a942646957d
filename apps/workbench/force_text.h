// Sentences and lines about the force of a tick.
#pragma once

#include <string>
#include <vector>

#include "haptics/servo/force_parts.h"
#include "sim/api/overlay.h"

namespace trephine::workbench {

/// Returns what is touched, how far the hand is beyond the surface, friction, and limits. `scene`: of the
/// hand in that tick.
std::vector<std::string> force_sentences(const haptics::ForceParts& parts, const haptics::TouchScene& scene);

/// Returns lines for a picture: from the hand to the proxy, the way of the proxy in this tick, normal,
/// friction cone, and the force with 6 mm per N.
sim::Overlay force_lines(const haptics::ForceParts& parts, const haptics::TouchScene& scene);

}  // namespace trephine::workbench
