// Playback of a recorded session in the window.
#pragma once

#include <string>

#include "apps/workbench/sessions.h"

namespace trephine::cli {

/// Plays a session that was opened from `file` until the window is closed.
Status play_in_window(workbench::OpenedSession& session, const std::string& file, const std::string& title);

}  // namespace trephine::cli
