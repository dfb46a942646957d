// Sessions of programs: recorded during a run, opened with the scan they belong to.
#pragma once

#include <memory>
#include <string>

#include "apps/workbench/operation.h"
#include "sim/replay.h"
#include "sim/session_writer.h"

namespace trephine::workbench {

/// Whether and where an operation is recorded.
struct RecordChoice {
  std::string file;
  bool is_embedding = false;
  bool is_autosave = false;  ///< taken away again when nothing was cut
  std::string program;       ///< who records, with version: kept in the session
};

/// Checks whether it can be started, before any work is done for it.
volume::Status check(const RecordChoice& choice);
/// Starts the recording that is asked for; null without one.
volume::Result<std::unique_ptr<sim::SessionWriter>> start_recording(const RecordChoice& choice,
                                                                    const Operation& operation);

/// Is this a file that a recording wrote?
bool is_session_file(const std::string& path);

/// A session with everything that its replay borrows. Not to be moved once opened.
struct OpenedSession {
  std::unique_ptr<sim::SessionReader> reader;
  Source source;
  std::unique_ptr<sim::Replay> replay;
  /// Scene of the first hand.
  const haptics::TouchScene& scene() const { return replay->engine().scene(); }
};
/// Finds the scan: `case_source` when given, in the session itself, or the built-in one that it names.
volume::Result<std::unique_ptr<OpenedSession>> open_session(const std::string& path,
                                                            const SourceChoice& case_source,
                                                            const Listener& listener = {});

/// Folder of sessions of windows: $XDG_STATE_HOME/trephine/sessions (~/.local/state/...), made when
/// missing; empty when there is no such place.
std::string autosave_folder();
/// A new name in it; empty without such a folder.
std::string autosave_path();
/// Keeps the twenty that were written last; none that is being written goes.
void prune_autosaves();

}  // namespace trephine::workbench
