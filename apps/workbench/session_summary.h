// SessionSummary: events, working hands and working position of a recorded session, read without a replay.
#pragma once

#include <glm/vec3.hpp>
#include <optional>
#include <vector>

#include "apps/workbench/event_text.h"
#include "sim/session/session_reader.h"

namespace trephine::workbench {

struct SessionSummary {
  struct Mark {
    double seconds = 0;
    EventLevel level = EventLevel::record;
    std::string text;
  };
  /// A hand that starts to work at a tick: its button is pressed.
  struct Active {
    std::uint64_t tick = 0;
    int hand = 0;
  };
  std::vector<Mark> marks;     ///< all events, by time
  std::vector<Active> active;  ///< by time
  /// Mean position of the hands while their buttons were pressed; world, mm. Empty: no button was pressed.
  std::optional<glm::dvec3> work_position;

  /// Returns the hand that works at a tick: the hand whose button was pressed last. Before the first press,
  /// returns the hand of that press; 0 if no button is ever pressed.
  int hand_at(std::uint64_t tick) const noexcept;
};

/// Reads a session file to its end. Ignores events of types that the program does not know. Takes 14 ms for
/// 100,000 ticks.
Result<SessionSummary> summarize_session(const std::string& file);

}  // namespace trephine::workbench
