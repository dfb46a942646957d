// Timeline: strokes, commands and events of a recorded session by time, read without a replay.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "apps/workbench/event_text.h"
#include "data-tools/cases/session_notes.h"
#include "sim/session/session_reader.h"

namespace trephine::workbench {

/// An entry of the timeline. A press is a stroke that removed and restored nothing. A note was written by an
/// instructor.
struct TimelineRow {
  enum class Kind : std::uint8_t { stroke, press, command, event, note };
  std::uint64_t tick = 0;
  Kind kind = Kind::event;
  int hand = 0;
  std::string text;
  std::string branch = {};  ///< branch of the history; may be empty
  // Fields of strokes and presses; commands have `units`:
  double seconds = 0;    ///< duration
  double strongest = 0;  ///< strongest force, N
  /// Removed matter, in the session's units; negative: restored.
  std::int64_t units = 0;
  // Fields of events; notes have the first two:
  EventLevel level = EventLevel::record;
  glm::dvec3 position_world{0.0};  ///< mm
  std::string step = {};           ///< the step of the procedure that began; empty for other events

  bool is_stroke() const noexcept { return kind == Kind::stroke || kind == Kind::press; }
};
/// Returns the name of a kind for reports: "stroke", "press", "command", "event" or "note".
const char* kind_name(TimelineRow::Kind kind) noexcept;

struct Timeline {
  std::vector<TimelineRow> rows;      ///< by time
  std::vector<std::string> branches;  ///< of the history; the current branch is last
  std::size_t strokes = 0;
  /// Volume of a unit, mm3; empty if the session was not closed, or nothing was removed.
  std::optional<double> unit_mm3;
};

/// Reads a session to its end. Commands that adopt derived data (sim::Adopt) are not listed.
Result<Timeline> read_timeline(sim::SessionReader& session);
/// Adds the notes of a session, after the other entries of their times.
void add_notes(Timeline& timeline, const std::vector<data_tools::SessionNote>& notes, double rate_hz);

}  // namespace trephine::workbench
