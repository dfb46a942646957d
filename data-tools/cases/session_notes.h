// Notes of an instructor about a recorded session, in a file next to it. The session itself is not changed.
#pragma once

#include <glm/vec3.hpp>
#include <optional>
#include <string>
#include <vector>

#include "volume/base/error.h"

namespace trephine::data_tools {

struct SessionNote {
  static constexpr std::size_t k_max_length = 500;  ///< characters of a text
  double seconds = 0;                               ///< time in the session
  std::optional<glm::dvec3> at_world;               ///< position, mm; nullopt: the note has none
  std::string text;
  friend bool operator==(const SessionNote&, const SessionNote&) = default;
};

/// Returns the path of a session's notes: its own path and ".notes".
std::string notes_path(const std::string& session);
/// Reads the notes of a session by time; empty if it has no notes. Error: an invalid file, with the line.
Result<std::vector<SessionNote>> read_notes(const std::string& session);
/// Replaces the notes of a session, in any order. Without notes the file is removed.
Status write_notes(const std::string& session, std::vector<SessionNote> notes);

}  // namespace trephine::data_tools
