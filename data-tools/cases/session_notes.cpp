#include "data-tools/cases/session_notes.h"

#include <algorithm>
#include <cerrno>
#include <filesystem>

#include "data-tools/cases/toml_reader_impl.h"
#include "data-tools/files/atomic_file.h"

namespace trephine::data_tools {

namespace {

constexpr int k_schema = 1;

void sort_by_time(std::vector<SessionNote>& notes) {
  std::stable_sort(notes.begin(), notes.end(),
                   [](const SessionNote& a, const SessionNote& b) { return a.seconds < b.seconds; });
}

}  // namespace

std::string notes_path(const std::string& session) { return session + ".notes"; }

Result<std::vector<SessionNote>> read_notes(const std::string& session) {
  const std::string path = notes_path(session);
  const std::string where = "the notes next to the session";
  std::error_code error;
  if (!std::filesystem::exists(path, error)) return std::vector<SessionNote>();
  const Result<std::string> text = read_toml_text(path, where, "file of notes");
  if (!text) return text.error();
  const Result<toml::value> parsed = parse_toml(text.value(), where, "file of notes");
  if (!parsed) return parsed.error();
  TomlReader reader(where);
  const toml::table& top = reader.table(parsed.value(), {"schema", "note"});
  if (Status schema_error = reader.check_schema(top, k_schema, "file of notes")) return *schema_error;
  constexpr double k_longest = 1e6;  // s
  std::vector<SessionNote> notes;
  for (const toml::value* value : reader.tables(top, "note")) {
    const toml::table& t = reader.table(*value, {"seconds", "at", "text"});
    const auto seconds = reader.number(t, "seconds", 0, k_longest);
    const auto words = reader.text(t, "text", 4 * SessionNote::k_max_length);  // bytes
    if (!seconds || !words)
      reader.fail(*value, "a note is not complete", words.value_or(""), "seconds = number, text = \"text\"");
    notes.push_back({seconds.value_or(0), reader.point(t, "at"), words.value_or("")});
  }
  if (const auto invalid = reader.error()) return *invalid;
  sort_by_time(notes);
  return notes;
}

Status write_notes(const std::string& session, std::vector<SessionNote> notes) {
  const std::string path = notes_path(session);
  if (notes.empty()) {
    std::error_code error;
    std::filesystem::remove(path, error);
    return error ? Status(cannot_write(path, error.value())) : std::nullopt;
  }
  sort_by_time(notes);
  std::string text = "# Notes about the session of this name. Times in s, positions in mm (LPS).\nschema = " +
                     std::to_string(k_schema) + "\n";
  for (const SessionNote& note : notes) {
    text += "\n[[note]]\nseconds = " + text_of(note.seconds) + "\n";
    if (note.at_world)
      text += "at = [" + text_of(note.at_world->x) + ", " + text_of(note.at_world->y) + ", " +
              text_of(note.at_world->z) + "]\n";
    text += "text = " + toml_text(note.text) + "\n";
  }
  return write_file_atomically(path, text);
}

}  // namespace trephine::data_tools
