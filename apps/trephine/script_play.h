// Plays a script for a command: with or without threads, recorded, with pictures.
#pragma once

#include "apps/trephine/report.h"
#include "apps/workbench/script.h"

namespace trephine::app {

struct ScriptRequest {
  data_tools::Script script;
  std::string folder, where;  ///< from where it sees its files; what to call it in errors
  workbench::RecordChoice record;
  bool is_live = false;
  std::string pictures;              ///< the folder for them; empty: none are taken
  std::vector<std::string> outputs;  ///< files in addition to the pictures, which will be written
  std::vector<std::string> in_use;   ///< files that no picture may replace
  bool wants_session = false;        ///< there is a recording afterwards, asked for or not
};

/// A file that is deleted with its owner, unless it is released.
struct TemporaryFile {
  std::string path;
  TemporaryFile() = default;
  TemporaryFile(TemporaryFile&& other) noexcept : path(std::exchange(other.path, {})) {}
  TemporaryFile& operator=(TemporaryFile&& other) noexcept { return std::swap(path, other.path), *this; }
  ~TemporaryFile();
};

struct PlayedScript {
  std::unique_ptr<workbench::ScriptRun> run;
  workbench::ScriptReport report;
  std::optional<workbench::ScriptRun::Live> live;
  std::vector<std::string> pictures;  ///< their names
  std::string session;
  TemporaryFile temporary;  ///< that session, when it is not to be kept
  double ready_seconds = 0, played_seconds = 0, drawing_seconds = 0;
};

volume::Result<PlayedScript> play_script(const ScriptRequest& request);
/// {rate, steps in us, lateness, ...} of a servo.
Json servo_json(const haptics::ServoReport& servo);
/// [{line, at_seconds, what, found, is_met}, ...], and the same for people.
Json checks_json(const workbench::ScriptReport& report);
std::string checks_text(const workbench::ScriptReport& report);

}  // namespace trephine::app
