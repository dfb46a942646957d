// The window in which a person without a device touches and drills: what it is asked for, what it reports.
#pragma once

#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <string>

#include "apps/workbench/listener.h"
#include "apps/workbench/session_summary.h"
#include "haptics/servo/servo_loop.h"
#include "sim/live_session.h"
#include "sim/overlay.h"
#include "sim/replay.h"
#include "sim/session_writer.h"

namespace trephine::view {

/// Start of an operation, or of its continuation.
struct WindowStart {
  sim::Engine engine;
  std::uint64_t first_tick = 0;
  /// Scene of the first hand, without detached bodies.
  const std::shared_ptr<const haptics::TouchScene>& scene() const { return engine.tool().scene; }
};

/// An operation that a person opened from within the window, with all that it needs while it lives.
struct OpenedScene {
  WindowStart start;
  std::string title;
  std::unique_ptr<sim::SessionWriter> recorder;
  std::string session_file;               ///< where the recorder writes; empty without
  std::vector<std::string> in_use;        ///< what it was read from: saving replaces none of it
  sim::Overlays plan;                     ///< shown in addition to the bone
  std::shared_ptr<void> owner = nullptr;  ///< keeps what `start` borrows; null where it borrows nothing
  double rate_hz = 1000;
  haptics::ForceOptions force = {};
};

/// Choice of what is solid.
struct ShapeRequest {
  double low = 300, high = std::numeric_limits<double>::infinity();
  std::string preset;       ///< as workbench::PresetChoice has it; empty: the range
  bool is_largest = false;  ///< without what hangs apart: a table, a head holder
};

/// Services of the program around a window: find and read scans, begin recordings.
struct WindowHost {
  using Listener = workbench::Listener;
  /// A folder, a file, "head" or "spine". Off the drawing thread; one of both at a time.
  std::function<volume::Result<OpenedScene>(const std::string& source, const Listener& listener)> open;
  /// A recorded session, to go on where it stopped, in the same file. Its scan: in the session, built in, or
  /// else the one that is open.
  std::function<volume::Result<OpenedScene>(const std::string& session, const Listener& listener)> resume;
  std::string session_folder;  ///< folder of sessions without a name; empty: nowhere
  /// The scan that was opened last, with another shape.
  std::function<volume::Result<OpenedScene>(const ShapeRequest& shape, const Listener& listener)> reshape;
};

struct WindowOptions {
  const sim::Catalogue* catalogue =
      nullptr;  ///< instruments and commands of the program; null: those of the start alone
  double rate_hz = 1000;
  haptics::ForceOptions force = {};
  std::shared_ptr<haptics::Device> device;  ///< drives the first hand; null: the mouse
  std::optional<double> seconds;            ///< close by itself after so long
  /// Asked in every frame: true closes the window in order, as its own button does.
  std::function<bool()> wants_to_end = [] { return false; };
  std::string screenshot;  ///< PNG at the end; empty for none
  char side = 0;           ///< from which it is seen, as Viewport::look_from has it; 0: from the front, above
  double free_pieces = 50;  ///< mm3: what a stroke cuts free and is so large comes off by itself; 0: nothing
  sim::Overlays plan;       ///< shown in addition to the bone
  bool has_tool = true;     ///< in a picture that is all that is wanted
  std::string title = "trephine";
  /// Draw the first frame and the screenshot into memory, no window (no display, or a screenshot is all that
  /// is wanted).
  bool is_offscreen = false;
  /// A cut state, to look at; null for the untouched volume.
  std::shared_ptr<const volume::Version> version;
  sim::SessionWriter* recorder = nullptr;  ///< records everything; finished when the window closes
  std::string session_file;                ///< where it writes
  std::vector<std::string> in_use;         ///< what was read: saving replaces none of it
  std::vector<std::string> notices;        ///< what was assumed of the scan: for the log
  std::optional<WindowStart> start;        ///< of what is operated on; nothing: a replay, or a picture
  sim::Replay* replay = nullptr;           ///< plays this instead of operating
  double replay_seconds = 0;               ///< its length
  workbench::SessionSummary summary;       ///< of what is replayed: camera, active hand, marks
  std::string layout_file;                 ///< where panes are remembered; empty: they are not
  WindowHost host;                         ///< without functions nothing else can be opened
  double width = 1100, height = 760;       ///< pixels
};

/// Report of the window.
struct WindowReport {
  std::string window = "none";  ///< "qt", "plain" or "none" (offscreen)
  haptics::ServoReport servo;
  double removed_mm3 = 0;
  std::size_t strokes = 0;
  std::uint64_t force_faults = 0;  ///< how often the force was switched off
  int frames = 0, drilling_frames = 0;
  int frames_skipped = 0;  ///< of `frames`: those whose picture would have been the same as the one before
  double frame_p50_ms = 0, frame_p99_ms = 0;        ///< of all frames
  double drilling_p50_ms = 0, drilling_p99_ms = 0;  ///< of those in which bone was being cut
  double first_frame_seconds = 0;                   ///< from the call to the first picture with bone to touch
  std::size_t triangles = 0;
  std::uint64_t offset_updates = 0;  ///< of a round tool's fields, and the longest of them
  double longest_offset_update_seconds = 0;
  sim::LiveSession::EditReport edits;
  volume::Status recording;  ///< how the recording ended, when it ended badly
};

/// A scene that outlives the window.
inline std::shared_ptr<const haptics::TouchScene> borrowed(const haptics::TouchScene& scene) {
  return {std::shared_ptr<void>(), &scene};
}

/// Runs until the window closes. The full window comes from its own library when that is installed
/// (libtrephine-window, Qt); otherwise, and in programs that embed, a plain one with mouse and keys: move to
/// ride the surface, left button to press and drill, wheel for depth, right button to turn, middle to tilt
/// the tool, Shift + right to move the picture, Ctrl + wheel to zoom; u or Ctrl+Z to undo, y or Ctrl+Y to
/// redo; a p l r s i for views; f to clear a fault; q to quit. `scene`: of a replay or a picture; an
/// operation has its own.
volume::Result<WindowReport> run_window(std::shared_ptr<const haptics::TouchScene> scene,
                                        const WindowOptions& options);
volume::Result<WindowReport> run_plain_window(const haptics::TouchScene& scene, const WindowOptions& options);

/// The entry of the window's library.
using RunQtWindow = volume::Result<WindowReport> (*)(std::shared_ptr<const haptics::TouchScene>,
                                                     const WindowOptions&);
inline constexpr const char* k_qt_window_entry = "trephine_run_qt_window";

}  // namespace trephine::view
