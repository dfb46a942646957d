// Playback of a script for a command: live or in lockstep, recorded, with pictures.
#pragma once

#include "apps/cli/report.h"
#include "apps/workbench/script.h"

namespace trephine::cli {

struct ScriptRequest {
  data_tools::Script script;
  std::string folder, where;  ///< folder that relative paths start from; name of the script in errors
  workbench::RecordChoice record;
  bool is_live = false;
  std::optional<workbench::Performance> performance;  ///< empty: hands move exactly
  std::string pictures;                               ///< folder of the pictures; empty: no pictures
  std::vector<std::string> outputs;                   ///< other files that will be written
  std::vector<std::string> in_use;                    ///< files that no picture may replace
  bool wants_session = false;                         ///< record a session even if no file was requested
};

/// Deletes the file `path` in the destructor. An empty `path` deletes nothing.
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
  std::vector<std::string> pictures;  ///< names of the pictures
  std::string session;                ///< file of the recorded session; empty: not recorded
  TemporaryFile temporary;            ///< deletes this file, unless its recording was requested
  double ready_seconds = 0, played_seconds = 0, drawing_seconds = 0;  ///< s: opening, playing, drawing
};

Result<PlayedScript> play_script(const ScriptRequest& request);
/// Report of a servo: {ticks, step_us, late_us, overruns, faults, notice}.
Json servo_json(const haptics::ServoReport& servo);
/// Script positions on the scan: [{name, at, outward, thickness_mm}, ...]; on a body: {name, body}.
Json places_json(const workbench::ScriptRun& run);
/// Checks of a script: [{line, at_seconds, what, found, is_met}, ...].
Json checks_json(const workbench::ScriptReport& report);
/// Adds a line for each check of the row `checks`. `unmet`: word of 6 characters for checks that are not met.
void print_checks(Rows& rows, const char* unmet = "FAILED");

}  // namespace trephine::cli
