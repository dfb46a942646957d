// Windows of recorded sessions: playback, continuation, and the score of the recording of any window.
#pragma once

#include <string>

#include "apps/view/view_window.h"
#include "apps/workbench/continued_session.h"
#include "apps/workbench/devices.h"

namespace trephine::cli {

/// A session that is played in a window.
struct Playback {
  std::string file;
  workbench::SourceChoice scan;  ///< with which it was opened
  std::string title;
  bool is_temporary = false;  ///< the file is deleted afterwards, and has no notes
};

/// Plays an open session until the window is closed. If the user chooses to operate from a moment of it,
/// continues a copy of its first part in a further window. `companion`: plays next to it, on the same
/// clock; null: no second session.
Status play_in_window(workbench::OpenedSession& session, const Playback& playback,
                      workbench::OpenedSession* companion = nullptr, const Playback& companion_playback = {});

/// Continues a session in a window until it is closed. `in_use`: the file of the session, then other files
/// that saving must not overwrite.
Result<view::WindowReport> continue_in_window(workbench::ContinuedSession continued, const std::string& scan,
                                              const std::vector<std::string>& in_use,
                                              const workbench::ChosenDevices& devices);

/// Returns `open_scan` for a session that has no scan of its own; otherwise an empty choice.
Result<workbench::SourceChoice> scan_for(const std::string& session, const std::string& open_scan);
/// Adds the services for recordings to a window: score, report and replay.
void add_recordings(view::WindowHost& host);

}  // namespace trephine::cli
