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
  /// Hand that works from a tick on.
  struct Active {
    std::uint64_t tick = 0;
    int hand = 0;
  };
  std::vector<Mark> marks;  ///< all events, by time
  std::vector<Active> active;
  /// Mean position of the tools while their buttons were pressed; world, mm.
  std::optional<glm::dvec3> work_position;

  /// Returns the hand that works at a tick: the last one that pressed its button, or the first one before
  /// that.
  int hand_at(std::uint64_t tick) const noexcept;
};

/// Reads a session file to its end. Ignores events of types that the program does not know. Takes 14 ms for
/// 100,000 ticks.
Result<SessionSummary> summarize_session(const std::string& file);

}  // namespace trephine::workbench
