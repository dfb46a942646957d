// Window in which a user touches and drills with a mouse or a device: options, host services and report.
#pragma once

#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <string>

#include "apps/view/display_mode.h"
#include "apps/view/head_tracker.h"
#include "apps/view/hmd.h"
#include "apps/view/structures.h"
#include "apps/workbench/listener.h"
#include "apps/workbench/session_summary.h"
#include "data-tools/cases/case_plan.h"
#include "haptics/servo/servo_loop.h"
#include "sim/api/finding.h"
#include "sim/api/overlay.h"
#include "sim/drivers/live_session.h"
#include "sim/drivers/replay.h"
#include "sim/session/session_writer.h"
#include "volume/scan/surgical_plan.h"

namespace trephine::view {

/// Start of an operation, or of its continuation.
struct WindowStart {
  sim::Engine engine;
  std::uint64_t first_tick = 0;
  /// Scene of the first hand, without detached bodies.
  const std::shared_ptr<const haptics::TouchScene>& scene() const { return engine.tool().scene; }
};

/// An operation that the user opened from the window, with everything that it needs.
struct OpenedScene {
  WindowStart start;
  std::string title;
  std::unique_ptr<sim::SessionWriter> recorder;
  std::string session_file;                          ///< file of the recorder; empty without a recorder
  std::vector<std::string> in_use;                   ///< its source files, which saving must not overwrite
  std::shared_ptr<const volume::SurgicalPlan> plan;  ///< null: no plan
  std::shared_ptr<void> owner = nullptr;  ///< owns the data that `start` borrows; null if it borrows nothing
  double rate_hz = 1000;
  haptics::ForceOptions force = {};
  std::string scan = {};                           ///< path of its scan, as WindowOptions::scan
  std::vector<data_tools::CaseModel> models = {};  ///< of the case, which a new case copies
};

/// Choice of the solid shape.
struct ShapeRequest {
  double low = 300, high = std::numeric_limits<double>::infinity();  ///< range of values
  std::string preset;       ///< name of a workbench::PresetChoice; empty: the range
  bool is_largest = false;  ///< only the largest connected part, without a table or head holder
};

/// Services of the program for its window: opens scans and sessions, and starts recordings.
struct WindowHost {
  using Listener = workbench::Listener;
  /// Opens a folder, a file, "head" or "spine". Not called on the drawing thread; one call at a time.
  std::function<Result<OpenedScene>(const std::string& source, const Listener& listener)> open;
  /// Continues a recorded session in the same file. The scan is stored in the session, is a built-in one, or
  /// is the scan that is open now.
  std::function<Result<OpenedScene>(const std::string& session, const Listener& listener)> resume;
  /// Opens the last scan again, with a further scan that is touched. `shape`: text of the shape of the
  /// further scan, for workbench::parse_shape().
  std::function<Result<OpenedScene>(const std::string& scan, const std::string& shape,
                                    const Listener& listener)>
      add_scan;
  std::string session_folder;  ///< folder of autosaved sessions; empty: no folder
  std::string
      interrupted_session;  ///< session whose program ended without closing it; empty: no such session
  /// Reopens the last scan with another shape.
  std::function<Result<OpenedScene>(const ShapeRequest& shape, const Listener& listener)> reshape;
  /// Scores a recording, like `trephine score`. `scan`: path of the scan, if the session does not contain it.
  /// `preliminary`: receives the score of the final state, which is known much earlier than that with the
  /// motion of the hands. Not called on the drawing thread. Null: no scores.
  std::function<Result<sim::Score>(const std::string& session, const std::string& scan,
                                   const std::function<void(const sim::Score&)>& preliminary,
                                   const Listener& listener)>
      score;
  /// Writes the report of a recording as a page. Not called on the drawing thread. Null: no reports.
  std::function<Status(const std::string& session, const std::string& scan, const std::string& page,
                       const Listener& listener)>
      report;
  /// Plays a recording in a window of its own. Returns when that window is closed or the listener's progress
  /// function stops the replay. Not called on the drawing thread. Null: no replays.
  std::function<Status(const std::string& session, const std::string& scan, const Listener& listener)> replay;
};

struct WindowOptions {
  /// Instruments and commands of the program; null: only those of `start`.
  const sim::Catalogue* catalogue = nullptr;
  double rate_hz = 1000;
  haptics::ForceOptions force = {};
  std::shared_ptr<haptics::Device> device;       ///< drives the first hand; null: the mouse
  std::shared_ptr<haptics::Device> left_device;  ///< drives the second hand; null: one hand
  std::shared_ptr<haptics::Device> pedal;        ///< acts as the button of the mouse; null: no pedal
  std::optional<double> seconds;                 ///< closes the window after this time, s
  /// Called in every frame; true closes the window, like its close button.
  std::function<bool()> should_close = [] { return false; };
  std::string screenshot;  ///< PNG file at the end; empty: no screenshot
  /// Side of the camera, as in Viewport::look_from; 0: front left above. In the full window, 0 shows a spine
  /// from the back; a replay or a continued session is shown from the side at which its tool worked.
  char side = 0;
  std::vector<StructureOpacity> opacities = {};  ///< of structures at the start
  std::string language;                          ///< one of k_languages; empty: that of the system
  DisplayMode display = {};                      ///< presentation of the picture at the start
  std::shared_ptr<Hmd> hmd;                      ///< for the mode headset; null: no headset
  std::shared_ptr<HeadTracker> head_tracker;     ///< position of the viewer's head; null: no tracker
  double free_pieces = 50;  ///< mm3; pieces of at least this size are detached after a stroke; 0: never
  std::vector<data_tools::CaseModel> models;         ///< of the case, which a new case copies
  std::shared_ptr<const volume::SurgicalPlan> plan;  ///< shown in addition to the bone; null: no plan
  bool has_tool = true;                              ///< draws a tool in a screenshot without a window
  std::string title = "trephine";
  /// Draws the first frame and the screenshot into memory, without a window.
  bool is_offscreen = false;
  /// Cut state to draw; null: the uncut volume.
  std::shared_ptr<const volume::Version> version;
  sim::SessionWriter* recorder = nullptr;  ///< records everything; finished when the window closes
  std::string session_file;                ///< file of the recorder
  std::string scan;                        ///< path of the open scan; empty: the session contains it
  std::vector<std::string> in_use;         ///< input files, which saving must not overwrite
  std::vector<std::string> notices;        ///< assumptions about the scan, for the log
  std::optional<WindowStart> start;        ///< the operation; nullopt: a replay, or a picture
  sim::Replay* replay = nullptr;           ///< plays this session instead of an operation
  double replay_seconds = 0;               ///< duration of the replay, s
  std::string replayed_file;               ///< file of the replay, with its notes next to it; empty: no notes
  bool may_take_over = false;              ///< offers to continue a replay from the shown moment
  workbench::SessionSummary
      summary;              ///< summary of the replay or continued session: camera, active hand, marks
  std::string layout_file;  ///< file of the pane layout; empty: not stored
  WindowHost host;  ///< services of the program; if they are null, no other scan or session can be opened
  double width = 1100, height = 760;  ///< pixels
  /// A second replay, in a window of its own, which follows the time and the view of the first window; null:
  /// no second replay.
  struct Companion;
  std::shared_ptr<const Companion> companion;
};

struct WindowOptions::Companion {
  std::shared_ptr<const haptics::TouchScene> scene;
  WindowOptions options;
};

/// Report of the window.
struct WindowReport {
  std::string window = "none";  ///< "qt", "plain" or "none" (offscreen)
  haptics::ServoReport servo;
  double removed_mm3 = 0;
  std::size_t strokes = 0;
  std::uint64_t force_faults = 0;  ///< number of times that the force was switched off
  int frames = 0, drilling_frames = 0;
  int frames_skipped = 0;                           ///< frames not drawn because the picture did not change
  double frame_p50_ms = 0, frame_p99_ms = 0;        ///< of drawn frames
  double drilling_p50_ms = 0, drilling_p99_ms = 0;  ///< of frames in which bone was cut
  double first_frame_seconds = 0;                   ///< from the call to the first picture of touchable bone
  std::size_t triangles = 0;
  std::uint64_t offset_updates = 0;          ///< number of updates of a round tool's fields
  double longest_offset_update_seconds = 0;  ///< longest of these updates
  sim::LiveSession::EditReport edits;
  Status recording_error;               ///< error of the recording, if it failed
  std::optional<double> taken_over_at;  ///< time of a replay from which the user continues, s
};

/// Returns a non-owning pointer to a scene that outlives the window.
inline std::shared_ptr<const haptics::TouchScene> borrowed(const haptics::TouchScene& scene) {
  return {std::shared_ptr<void>(), &scene};
}

/// Runs a window until it closes. Uses the full window of libtrephine-window (Qt) if it is installed;
/// otherwise a plain window with mouse and keys: move to follow the surface, left button to press and drill,
/// wheel for depth, right button to turn, middle to tilt the tool, Shift + right to move the picture, Ctrl +
/// wheel to zoom; u or Ctrl+Z to undo, y or Ctrl+Y to redo; a p l r s i for views; f to clear a fault; q to
/// quit. `scene`: scene of a replay or of a picture; it is ignored for an operation, which has its own scene.
/// Error: no display, or a replay without the full window.
Result<WindowReport> run_window(std::shared_ptr<const haptics::TouchScene> scene,
                                const WindowOptions& options);
Result<WindowReport> run_plain_window(const haptics::TouchScene& scene, const WindowOptions& options);

/// Entry point of the window's library.
using RunQtWindow = Result<WindowReport> (*)(std::shared_ptr<const haptics::TouchScene>,
                                             const WindowOptions&);
inline constexpr const char* k_qt_window_entry = "trephine_run_qt_window";

}  // namespace trephine::view
