// Notes of an instructor about a recorded session, in a file next to it. The session itself is not changed.
#pragma once

#include <glm/vec3.hpp>
#include <optional>
#include <string>
#include <vector>

#include "volume/base/error.h"

namespace trephine::data_tools {

struct SessionNote {
  static constexpr std::size_t k_max_length = 500;  ///< largest number of characters of a text
  double seconds = 0;                               ///< time in the session
  std::optional<glm::dvec3> at_world;               ///< position, mm; nullopt: the note has none
  std::string text;
  friend bool operator==(const SessionNote&, const SessionNote&) = default;
};

/// Returns the path of a session's notes: the path of the session followed by ".notes".
std::string notes_path(const std::string& session);
/// Reads the notes of a session, sorted by time; empty if it has no notes. Error, with the line, if the file
/// is invalid.
Result<std::vector<SessionNote>> read_notes(const std::string& session);
/// Replaces all notes of a session by `notes`, which may be in any order. Removes the file if `notes` is
/// empty.
Status write_notes(const std::string& session, std::vector<SessionNote> notes);

}  // namespace trephine::data_tools
