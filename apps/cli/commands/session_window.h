// Windows of recorded sessions: playback and continuation; score, report and replay for the recordings of any
// window.
#pragma once

#include <string>

#include "apps/cli/options/display_options.h"
#include "apps/view/view_window.h"
#include "apps/workbench/continued_session.h"
#include "apps/workbench/devices.h"

namespace trephine::cli {

/// A session that is played in a window.
struct Playback {
  std::string file;
  workbench::SourceChoice scan;  ///< scan with which the session was opened
  std::string title;
  bool is_temporary = false;  ///< the file is deleted afterwards, and has no notes
};

/// Plays an open session until the window is closed. If the user chooses to operate from a moment of the
/// session, continues a copy of the part before this moment in a further window. `companion`: second session,
/// which plays side by side with the first on the same clock; null: no second session.
Status play_in_window(workbench::OpenedSession& session, const Playback& playback,
                      const DisplayArguments& display, workbench::OpenedSession* companion = nullptr,
                      const Playback& companion_playback = {});

/// Continues a session in a window until the window is closed. `scan`: path of its scan; empty: the session
/// opens without one. `in_use`: the file of the session, then other files that saving must not overwrite.
Result<view::WindowReport> continue_in_window(workbench::ContinuedSession continued, const std::string& scan,
                                              const std::vector<std::string>& in_use,
                                              const workbench::ChosenDevices& devices,
                                              const DisplayArguments& display);

/// Returns `open_scan` for a session that neither contains its scan nor names a built-in scan; otherwise an
/// empty choice.
Result<workbench::SourceChoice> scan_for(const std::string& session, const std::string& open_scan);
/// Adds the services for recordings to a window: score, report and replay. `language`: of the window of a
/// replay; empty: that of the system.
void add_recordings(view::WindowHost& host, const std::string& language);

}  // namespace trephine::cli
