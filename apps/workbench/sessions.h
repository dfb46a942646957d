// Sessions as the commands use them: recorded beside a run, opened with the scan they belong to.
#pragma once

#include <memory>
#include <string>

#include "apps/trephine/source.h"
#include "haptics/proxy/methods.h"
#include "modules/drilling/burr.h"
#include "sim/replay.h"
#include "sim/session_writer.h"

namespace trephine::app {

/// --record FILE [--embed]
struct RecordChoice {
  std::string file;
  bool is_embedding = false;
  bool is_autosave = false;  ///< taken away again when nothing was cut
};

/// What this program can do beside touching.
const sim::Catalogue& catalogue();

/// What must not be cut of a case, as a session tells it and as an engine watches it.
struct ForbiddenParts {
  std::vector<sim::StructureSpec> told;
  std::vector<std::shared_ptr<const sim::Forbidden>> watched;
};
volume::Result<ForbiddenParts> forbidden_of(const Source& source);

/// What would keep it from being started, before any work is done for it.
volume::Status check_record(const RecordChoice& choice);
/// Starts the recording that is asked for; null without one.
volume::Result<std::unique_ptr<sim::SessionWriter>> start_recording(
    const RecordChoice& choice, const Source& source, const haptics::TouchScene& scene,
    const haptics::ProxyMethod& method, const haptics::ServoOptions& options,
    const sim::Instrument& instrument, std::vector<std::string> effects = {},
    std::vector<sim::StructureSpec> forbidden = {});
/// Ends it; a recording that ended early is said, and what was written is kept.
volume::Status finish_recording(sim::SessionWriter* writer, const sim::Engine& engine, std::uint64_t dropped);

/// Is this a file that --record wrote?
bool is_session_file(const std::string& path);

/// A session with everything that its replay borrows. Not to be moved once opened.
struct OpenedSession {
  std::unique_ptr<sim::SessionReader> reader;
  Source source;
  /// What the first hand touches.
  const haptics::TouchScene& scene() const { return replay->engine().scene(); }
  /// Of a hand, as the session begins; null when it has none.
  const drilling::Burr* burr(std::size_t hand) const;
  std::unique_ptr<sim::Replay> replay;
};
/// Finds the scan: `case_source` when given, in the session itself, or the built-in one that it names.
volume::Result<std::unique_ptr<OpenedSession>> open_session(const std::string& path,
                                                            const std::string& case_source);

/// Where view keeps its sessions: $XDG_STATE_HOME/trephine/sessions (~/.local/state/...), made when missing;
/// empty when there is no such place.
std::string autosave_folder();
/// A new name in it; empty likewise.
std::string autosave_path();
/// Keeps the twenty that were written last; none that is being written goes.
void prune_autosaves();

/// What `info SESSION` says.
volume::Result<Outcome> describe_session_file(const std::string& path);

}  // namespace trephine::app
