// Recording of operations as sessions, opening of sessions with their scans, and autosaved sessions.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "apps/workbench/operation.h"
#include "sim/drivers/replay.h"
#include "sim/session/session_writer.h"

namespace trephine::workbench {

/// Recording of an operation.
struct RecordChoice {
  std::string file;           ///< empty: no recording
  bool is_embedding = false;  ///< the file also contains the scan
  bool is_autosave = false;   ///< the finished file is deleted unless SessionWriter::has_edits()
  std::string program;        ///< name and version of the recording program, stored in the session
};

/// Checks whether the recording can be started, before other work is done.
Status check(const RecordChoice& choice);
/// Starts the requested recording; null if no recording is requested.
Result<std::unique_ptr<sim::SessionWriter>> start_recording(const RecordChoice& choice,
                                                            const Operation& operation);

/// True if the file is a recorded session.
bool is_session_file(const std::string& path);

/// Returns the recorded motion of the first hand. Error if the hand has no tick.
Result<haptics::PosePath> path_of_session(const std::string& path);

/// True if the session opens without another file: it contains its scan, or names a built-in one.
bool has_own_scan(const sim::SessionReader& session);

/// A session with its replay, and the objects that the replay borrows. Must not be moved once opened.
struct OpenedSession {
  std::unique_ptr<sim::SessionReader> reader;
  Source source;
  std::unique_ptr<sim::Replay> replay;
  /// Scene of the first hand.
  const haptics::TouchScene& scene() const { return replay->engine().scene(); }
};
/// Opens a session with its scan: the scan in the session, or else `case_source`, or else the built-in
/// phantom that the session names.
Result<std::unique_ptr<OpenedSession>> open_session(const std::string& path, const SourceChoice& case_source,
                                                    const Listener& listener = {});

/// Returns the tick nearest to a time of a session, s; without a time, the number of ticks of the session.
/// Error with the location "until" if the session does not contain the time.
Result<std::uint64_t> tick_at(const sim::SessionReader& session, std::optional<double> seconds);

/// Returns the folder of autosaves, $XDG_STATE_HOME/trephine/sessions, by default in ~/.local/state. Creates
/// the folder if it is missing; returns an empty text if it cannot be created.
std::string autosave_folder();
/// Returns a new file name in autosave_folder(); empty without such a folder.
std::string autosave_path();
/// Returns a new file name in autosave_folder(). Error if there is no such folder.
Result<std::string> new_autosave();
/// An entry in a list of autosaves.
struct Autosave {
  std::string file;
  std::string title;            ///< title of its procedure, or else name of its case; may be empty
  std::string begin;            ///< local time, "2026-11-27 14:03"
  double seconds = 0;           ///< duration
  bool is_interrupted = false;  ///< its program ended without closing it
  bool needs_scan = false;      ///< its scan is neither in the file nor built in
};
/// Returns the newest autosaves that can be opened and that no program is writing, in the order of their
/// beginning, newest first.
std::vector<Autosave> list_autosaves(std::size_t most);
/// Returns the newest autosave that no program is writing, if its program ended without closing it; empty
/// otherwise.
std::string interrupted_autosave();
/// Deletes all but the twenty newest autosaves, with their notes. Keeps those that are being written.
void prune_autosaves();

}  // namespace trephine::workbench
