// A session in the window, by itself.
#pragma once

#include <string>

#include "apps/workbench/sessions.h"

namespace trephine::app {

/// Plays a session that was opened from `file` until the window is closed.
volume::Status play_in_window(workbench::OpenedSession& session, const std::string& file,
                              const std::string& title);

}  // namespace trephine::app
