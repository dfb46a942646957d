// Sentences and lines that explain the force of a tick.
#pragma once

#include <string>
#include <vector>

#include "haptics/servo/force_parts.h"
#include "sim/api/overlay.h"

namespace trephine::workbench {

/// Returns sentences about the touched item, the distance of the hand beyond its surface, friction, limits
/// and faults. `scene`: scene of the hand in that tick.
std::vector<std::string> force_sentences(const haptics::ForceParts& parts, const haptics::TouchScene& scene);

/// Returns lines for a picture: the line from the hand to the proxy, the path of the proxy in this tick, the
/// normal, the friction cone, and the force at 6 mm per N.
sim::Overlay force_lines(const haptics::ForceParts& parts, const haptics::TouchScene& scene);

}  // namespace trephine::workbench
