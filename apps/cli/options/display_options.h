// Options of the presentation of a window: language, stereo, mirror and head tracker.
#pragma once

#include <string>

#include "apps/cli/options/options.h"
#include "apps/view/view_window.h"

namespace trephine::cli {

struct DisplayArguments {
  std::string language, eyes = "one", head_tracker;
  view::DisplayMode mode;
};

/// Adds --language.
void add_language(Options& options, std::string& language);
/// Returns an error if there is no catalogue of a language; an empty name is that of the system.
Status check_language(const std::string& language);
/// Adds --language, --eyes, --mirror, --head-tracker, --screen-width and --viewing-distance.
void add_display(Options& options, DisplayArguments& arguments);
/// Sets the presentation of a window, and opens its head tracker. Errors: an unknown name, a value out of
/// range, and those of view::open_head_tracker().
Status choose_display(const DisplayArguments& arguments, view::WindowOptions& options);

}  // namespace trephine::cli
