// The window in which a person without a device touches and drills.
#pragma once

#include <optional>
#include <string>

#include "apps/view/bone_view.h"
#include "haptics/servo_loop.h"
#include "modules/drilling/burr.h"
#include "sim/session_writer.h"

namespace trephine::view {

/// Where a session goes on: the state that it had reached, and the tool that is part of it.
struct WindowStart {
  sim::EditSession edits;
  drilling::Burr* burr;
  std::uint64_t first_tick = 0;
};

struct WindowOptions {
  drilling::BurrOptions burr;
  double rate_hz = 1000;
  std::optional<double> seconds;  ///< close by itself after so long
  std::string screenshot;         ///< PNG at the end; empty for none
  std::string title = "trephine";
  /// Draw the first frame and the screenshot into memory, no window (no display, or a screenshot is all that
  /// is wanted).
  bool is_offscreen = false;
  /// What has already been cut, to look at; null for the untouched volume.
  std::shared_ptr<const volume::Version> version;
  sim::SessionWriter* recorder = nullptr;  ///< told of everything; finished when the window closes
  std::optional<WindowStart> start;        ///< nothing: from the untouched volume
};

/// What happened in the window.
struct WindowReport {
  haptics::ServoReport servo;
  double removed_mm3 = 0;
  volume::Status recording;  ///< how the recording ended, when it ended badly
  std::size_t strokes = 0;
  int frames = 0;
  double frame_p50_ms = 0, frame_p99_ms = 0;
  double first_frame_seconds = 0;  ///< from the call to the first complete picture
  std::size_t triangles = 0;
};

/// Runs until the window closes. Needs a display unless offscreen. Mouse: move to ride the surface, left
/// button to press and drill, wheel for depth, right button to orbit, middle to pan, Ctrl + wheel to zoom;
/// u or Ctrl+Z to undo, y or Ctrl+Y to redo; a p l r s i for views; f to clear a fault; q to quit.
volume::Result<WindowReport> run_window(const haptics::TouchScene& scene, const WindowOptions& options);

}  // namespace trephine::view
