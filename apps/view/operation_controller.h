// A person operates: cursor and buttons become a stylus, the live session becomes pictures.
#pragma once

#include <chrono>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "apps/view/mouse_device.h"
#include "apps/view/notices.h"
#include "apps/view/tool_guide.h"
#include "apps/view/view_window.h"
#include "apps/view/viewport.h"
#include "apps/workbench/clock.h"
#include "sim/live_session.h"

namespace trephine::view {

/// No windowing toolkit in here: a window calls it at its own rate. One thread: the one that draws.
class OperationController {
 public:
  /// Borrows scene, which is the one of options.start, recorder and window.
  OperationController(const haptics::TouchScene& scene, const WindowOptions& options,
                      vtkRenderWindow* window);
  ~OperationController();

  /// Asks for the first pictures and starts servo and edits.
  volume::Status start();
  /// Stops them, ends the recording, and says what happened. A second call says the same.
  const WindowReport& finish();

  /// Sets the cursor: shares of the picture's width and height from the lower left.
  void point(double x, double y) {
    if (!is_tip_held_) x_ = x, y_ = y;
  }
  void press(bool is_down) {
    if (is_pressed_ && !is_down)
      request_ = glm::dvec3(1e9);  // released: the stylus is lifted off, wherever it is held
    is_pressed_ = is_down;
    has_click_ = has_click_ || is_down;
  }
  bool is_pressed() const noexcept { return is_pressed_; }
  /// Turns the tool about its shaft, by so many steps of 15 degrees.
  void roll(int steps) { roll_ += steps; }
  /// Leans the shaft about the tip toward the right and the upper edge of the picture, degrees. It leans at
  /// most 75 degrees from how it is held otherwise.
  void tilt(double right, double up);
  /// Direction of the shaft before it is tilted.
  enum class Hold : std::uint8_t { surface, viewer, fixed };
  /// Changes to the next way of holding it; a tilt ends. A fixed shaft stays as it is now.
  Hold hold_next();
  /// Degrees between the shaft and how it is held without tilt.
  double tilted() const;
  /// Moves the tip over what is seen, mm in the picture, as a cursor would.
  void move_tip(double right, double up);
  /// Keeps the tip where it is, whatever the cursor does, until it is let go.
  void hold_tip(bool is_held) { is_tip_held_ = is_held; }
  /// Slides the foot of a Kerrison that is under an edge. False: it is not under one.
  bool slide_foot(int steps) { return guide_.slide(steps); }
  /// Draws where depth images are made.
  void show_clip_volumes(bool are_shown) {
    if (!are_shown && shows_clip_volumes_) shown_.reset();
    shows_clip_volumes_ = are_shown;
  }
  /// Sets the depth of a pressed stylus below the surface, mm.
  void set_depth(double mm);
  double depth() const noexcept { return depth_mm_; }
  /// The instrument in the hand; empty: without one.
  const sim::Value& tool() const noexcept { return state_.tool; }
  /// Gives the hand an instrument with these parameters; one that touches with other balls than the hand has
  /// comes when those are ready, some seconds later.
  void take(sim::Value instrument);
  bool is_taking() const noexcept { return !taken_.is_empty(); }
  /// Sends a command to a module.
  void apply(sim::Value what) { live_.apply(sim::Command(std::move(what), 0)); }
  /// Frees what was cut off the bone.
  void free_pieces() { apply(sim::FreePieces()); }
  /// Releases what the hand holds, or grasps the piece that it touches. False: it touches none.
  bool take_or_put_down();
  /// Place that the tool touches, or that the cursor is on while the tool hovers over it; empty: over
  /// nothing.
  std::optional<glm::dvec3> touched() const;
  /// Takes the point of the plan that is nearest to where it touches, until it is put down: it goes with what
  /// touches. False: not within a few millimetres.
  bool grab_point();
  void drop_point() { grabbed_ = {}; }
  bool has_point() const noexcept { return !grabbed_.is_empty(); }
  void undo() { live_.undo(); }
  void redo() { live_.redo(); }
  /// Back or on to where so many strokes are applied.
  void go_to_stroke(std::size_t strokes);
  /// To be compared: waits for the edits, some milliseconds.
  std::vector<sim::LiveSession::Place> places() { return live_.places().get(); }
  const haptics::TouchScene& scene() const noexcept { return *scene_; }
  /// Forbidden structures: the same from beginning to end.
  std::span<const std::shared_ptr<const sim::Forbidden>> forbidden() const {
    return live_.engine().forbidden();
  }
  void reset_faults() { live_.reset_faults(); }

  /// One frame: the stylus moves on, news are fetched, the picture is drawn.
  void frame();
  const sim::LiveState& state() const noexcept { return state_; }
  /// That were drawn so far.
  int frames() const noexcept { return report_.frames; }
  /// Number of these that were not drawn, since their picture would have been the same as the one before.
  int frames_skipped() const noexcept { return report_.frames_skipped; }
  /// Pictures of scenery in which something hid the hand, so that its contact stays as it was.
  std::uint64_t hidden_pictures() const noexcept { return hidden_; }
  haptics::ServoReport servo() const { return live_.servo_report(); }
  /// Latched faults in words, with their remedies; empty without faults.
  std::string fault_text() const;
  /// Why the newest command was refused, once; empty when none was.
  std::string take_refusal() { return std::exchange(refused_, {}); }
  /// Returns the time since this operation's window opened, s.
  double seconds() const noexcept { return workbench::seconds_since(started_); }
  /// Log of the operation, in sentences. Refused commands are in it too.
  const Notices& notices() const noexcept { return notices_; }
  /// Adds a sentence to the log.
  void note(std::string text) {
    notices_.add({seconds(), 0, workbench::EventLevel::record, std::move(text)});
  }
  /// Returns the guide of a tool with a foot.
  const ToolGuide& guide() const noexcept { return guide_; }
  /// Returns the messages to show at the tool now; what lasts (a fault, a tool inside a structure) first.
  std::string notice_text() const;
  workbench::EventLevel notice_level() const;
  Viewport& viewport() noexcept { return viewport_; }
  const std::shared_ptr<const volume::Version>& version() const noexcept { return version_; }
  /// Frozen current state: later cuts do not show in it. Waits for the edits, some
  /// milliseconds.
  std::shared_ptr<const volume::Version> frozen() { return live_.snapshot().get()->world.version; }

 private:
  void collect_notices();
  void restore_force();
  void follow_cursor();
  double above_soft(const Ray& ray, double along) const;
  void drag_point();
  void feel_scenery();
  void go_on_taking();
  double distance_to_bodies(const Ray& ray) const;
  void follow_surface(const Ray& ray, bool is_over_bone);
  bool follow_guide(const Ray& ray, double hit);
  std::optional<glm::dvec3> bone_beside(const Ray& ray, double hit);
  glm::dvec3 shaft() const { return tilt_ * shaft_; }

  const haptics::TouchScene* scene_;
  WindowOptions options_;
  Viewport viewport_;
  MouseDevice mouse_;
  haptics::Device* devices_[1];
  sim::LiveSession live_;
  sim::LiveState state_;
  std::shared_ptr<const volume::Version> version_;
  double x_ = 0.5, y_ = 0.5, depth_mm_ = 2, reach_ = 300;
  int roll_ = 0;
  std::shared_ptr<const volume::Version> untouched_;  ///< by which a tool is held, whatever is cut
  glm::dvec3 shaft_{0, 0, 1};                         ///< unit, of the mouse's tool, before it is tilted
  glm::dquat tilt_{1, 0, 0, 0};
  std::vector<volume::Field> solids_;  ///< what counts as bone
  Hold hold_ = Hold::surface;
  ToolGuide guide_;
  std::chrono::steady_clock::time_point guided_at_;
  bool is_over_bone_ = false;  ///< the cursor
  bool has_click_ = false;     ///< since the last frame, however short
  bool is_tip_held_ = false, is_pressed_ = false, is_finished_ = false, is_started_ = false;
  bool shows_clip_volumes_ = false;
  int scenery_ = -1;        ///< the item that is touched as it is drawn; -1: no such item
  volume::Eye drawn_from_;  ///< when its depth was asked for last, and where
  glm::dvec3 asked_at_{1e9};
  const haptics::MeshTree* drawn_ = nullptr;
  std::uint64_t hidden_ = 0, felt_picture_ = 0;
  std::optional<glm::dvec3> landing_;  ///< world: when the next picture is adopted
  glm::dvec3 request_{1e9};
  std::optional<std::size_t> requested_stroke_;  ///< until it is there
  std::string refused_;
  Notices notices_;
  std::chrono::steady_clock::time_point started_;
  std::optional<std::chrono::steady_clock::time_point> fault_since_;  ///< of a mouse's hand
  sim::Value grabbed_;          ///< the command that moves what is held; empty: nothing is
  glm::dvec3 dragged_to_{0.0};  ///< last requested place
  int frames_since_drag_ = 0;
  sim::Value taken_;   ///< an instrument that waits for its balls; empty: none
  sim::Value before_;  ///< what the hand had until then, for when they do not come
  int frames_without_job_ = 0;
  double wanted_radius_ = 0;
  std::size_t wanted_balls_ = 0;
  std::shared_ptr<const sim::Overlays> shown_;  ///< in the picture
  std::vector<float> frame_ms_, drilling_ms_;
  WindowReport report_;
};

}  // namespace trephine::view
