// OperationController: moves a stylus by cursor and buttons, and shows a live session in a picture.
#pragma once

#include <chrono>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "apps/view/line_guide.h"
#include "apps/view/mouse_device.h"
#include "apps/view/notices.h"
#include "apps/view/pedal_button.h"
#include "apps/view/piece_guard.h"
#include "apps/view/step_guide.h"
#include "apps/view/tool_appearance.h"
#include "apps/view/tool_guide.h"
#include "apps/view/view_window.h"
#include "apps/view/viewport.h"
#include "apps/workbench/clock.h"
#include "sim/drivers/live_session.h"

namespace trephine::view {

/// Independent of the windowing toolkit: a window calls frame() at its own rate. Drawing thread only.
class OperationController {
 public:
  /// Borrows scene (that of options.start), recorder and window.
  OperationController(const haptics::TouchScene& scene, const WindowOptions& options,
                      vtkRenderWindow* window);
  ~OperationController();

  /// Requests the first pictures, and starts the servo and the edits.
  Status start();
  /// Stops the servo and the edits, ends the recording, and returns the report. A later call returns it
  /// again.
  const WindowReport& finish();

  /// Sets the cursor: shares of the picture's width and height from the lower left. No effect while the tip
  /// is held. The tool of a mouse is not drawn before the cursor was in the picture.
  void set_cursor(double x, double y) {
    if (!is_tip_held_) x_ = x, y_ = y;
    was_in_picture_ = was_in_picture_ || (x >= 0 && x <= 1 && y >= 0 && y <= 1);
  }
  /// Presses or releases the button of the mouse or the pedal.
  void press(bool is_down) {
    if (is_pressed_ && !is_down) {
      is_lifted_ = true;
      mouse_.release();
    }
    if (is_down && !is_pressed_ && state_.tool.is_empty() && !options_.device && !viewport_.has_model_tool())
      show_refusal("No tool is in the hand. Choose one in the panel Tools.");
    is_pressed_ = is_down;
    has_click_ = has_click_ || is_down;
  }
  bool is_pressed() const noexcept { return is_pressed_; }
  /// Turns the tool about its shaft, in steps of 15 degrees.
  void roll(int steps) { roll_ += steps; }
  /// Tilts the shaft about the tip by these angles (degrees) toward the right and the upper edge of the
  /// picture. A tilt to more than 75 degrees from the untilted direction has no effect.
  void tilt(double right, double up);
  /// Direction of the shaft before it is tilted: along the normal of the surface under the cursor, toward the
  /// viewer, or fixed.
  enum class ShaftMode : std::uint8_t { surface, viewer, fixed };
  /// Selects the next mode and resets the tilt. ShaftMode::fixed keeps the current direction of the shaft,
  /// including its tilt.
  ShaftMode select_next_shaft_mode();
  /// Angle (degrees) between the shaft and its untilted direction.
  double tilt_angle() const;
  /// Moves the cursor so that the tip moves by these distances parallel to the picture, mm.
  void move_tip(double right, double up);
  /// Keeps the tip at its position, independent of the cursor, until it is released.
  void hold_tip(bool is_held) { is_tip_held_ = is_held; }
  /// Slides the foot of a held Kerrison farther under the bone, or an inserted tool farther along its line,
  /// by steps of 0.5 mm; negative: back. Returns false if no guide holds the tool.
  bool slide_tool(int steps) { return guide_.slide(steps) || line_.advance(0.5 * steps); }
  /// Shows or hides the clip volumes of depth images.
  void show_clip_volumes(bool are_shown) {
    if (!are_shown && shows_clip_volumes_) shown_.reset();
    shows_clip_volumes_ = are_shown;
  }
  /// Shows or hides the workspaces of the devices. Returns false if no device has a known workspace.
  bool show_workspaces(bool are_shown);
  /// Sets the depth of a pressed stylus below the surface, mm; limited to 0.5 to 12.
  void set_depth(double mm);
  double depth() const noexcept { return depth_mm_; }
  /// Number of hands: 2 with a device for the left hand.
  std::size_t hand_count() const noexcept { return devices_.size(); }
  /// The instrument of a hand; empty: no instrument.
  const sim::Value& tool(std::size_t hand = 0) const noexcept { return state_.tools[hand].parameters; }
  /// Replaces the instrument of a hand. If the new instrument touches with other balls than the current
  /// one, it is taken when the offset fields of these balls are built, some seconds later.
  void take_instrument(sim::Value instrument, std::size_t hand = 0);
  /// True while an instrument waits for its offset fields.
  bool is_changing_instrument() const noexcept { return !requested_tool_.is_empty(); }
  /// Removes the instrument of a hand, which then only touches.
  void remove_instrument(std::size_t hand = 0) { apply(sim::RemoveInstrument(), hand); }
  /// Guide through the procedure of the plan; null without a procedure.
  const StepGuide* steps() const noexcept { return steps_ ? &*steps_ : nullptr; }
  /// Requests a step of the procedure; first removes the instrument if that step does not allow it.
  void go_to_step(const std::string& name) {
    if (steps_ && steps_->needs_empty_hand(name))
      for (std::size_t hand = 0; hand < hand_count(); ++hand)
        if (!tool(hand).is_empty()) remove_instrument(hand);
    apply(sim::GoToStep{name});
  }
  /// Sends a command of a hand to the operation.
  void apply(sim::Value what, std::size_t hand = 0) {
    live_.apply(sim::Command(std::move(what), static_cast<std::uint8_t>(hand)));
  }
  /// Detaches pieces that were cut off the bone.
  void free_pieces() { apply(sim::FreePieces()); }
  /// Releases the held piece, or grasps the piece that the hand touches. Returns false if there is no piece.
  bool grasp_or_release();
  /// Puts the held or touched piece back to the position at which it was detached. Returns false if there is
  /// no detached piece.
  bool put_piece_back();
  /// Point of the surface under the cursor; with a device or while a guide holds the tool, the point that the
  /// tool touches. nullopt if there is no such point.
  std::optional<glm::dvec3> surface_point() const;
  /// Returns the visible point of bone, a cut face or a body under the cursor; with a device,
  /// surface_point().
  std::optional<glm::dvec3> picked_point();
  /// Grasps the handle of an overlay (anchor of an outline, pin of a clamp) that is nearest to
  /// surface_point(). The handle follows surface_point() until release_handle() or a refused command. Returns
  /// false if no handle is within a few millimetres.
  bool grasp_handle();
  void release_handle() { dragged_handle_ = {}; }
  bool has_handle() const noexcept { return !dragged_handle_.is_empty(); }
  /// Undoes or redoes the last change. After a release of the button, the request is sent only when the servo
  /// has processed the last ticks of the stroke: otherwise these ticks would cut after the undo.
  void undo() { change_history(HistoryStep::undo); }
  void redo() { change_history(HistoryStep::redo); }
  /// Undoes or redoes to the state with this number of strokes.
  void go_to_stroke(std::size_t strokes);
  /// States of the history that can be compared. Waits for the edits, some milliseconds.
  std::vector<sim::LiveSession::HistoryState> history_states() { return live_.history_states().get(); }
  const haptics::TouchScene& scene() const noexcept { return *scene_; }
  /// Forbidden structures; constant during an operation.
  std::span<const std::shared_ptr<const sim::Forbidden>> forbidden() const {
    return live_.engine().forbidden();
  }
  void reset_faults() { live_.reset_faults(); }
  /// Shows, at the tool, the reason why an action of the user is not possible, and logs the reason.
  void show_refusal(const char* reason) { add_notice(reason, workbench::EventLevel::refusal); }

  /// Executes one frame: moves the stylus, fetches the state, and draws the picture.
  void frame();
  const sim::LiveState& state() const noexcept { return state_; }
  /// Number of frames so far.
  int frames() const noexcept { return report_.frames; }
  /// Number of frames that were not drawn because the picture did not change.
  int frames_skipped() const noexcept { return report_.frames_skipped; }
  /// Number of depth pictures of the scenery that were not used because an object hid the hand in them.
  std::uint64_t hidden_pictures() const noexcept { return hidden_pictures_; }
  haptics::ServoReport servo() const { return live_.servo_report(); }
  /// Returns a text with the latched faults or else with the forbidden structure that the tool is in, and
  /// with the remedy; empty if there is neither.
  std::string fault_text() const;
  /// Returns once the reason why the newest command was refused; empty if no command was refused.
  std::string take_refusal() { return std::exchange(refused_, {}); }
  /// Returns the time since this operation's window opened, s.
  double seconds() const noexcept { return workbench::seconds_since(started_); }
  /// Log of the operation in sentences, including refused commands.
  const Notices& notices() const noexcept { return notices_; }
  /// Adds a sentence to the log.
  void note(std::string text) {
    notices_.add({seconds(), 0, workbench::EventLevel::record, std::move(text)});
  }
  /// True if a guide holds the tool, independent of the cursor: with its foot under bone, or on a line.
  bool is_guided() const noexcept { return guide_.is_holding() || line_.is_holding(); }
  /// True if a probe, a catheter or a perforator is in its track.
  bool is_inserted() const noexcept { return line_.inserted_depth() > 0; }
  /// Returns true while a tool is in a structure that it must not enter.
  bool is_in_structure() const { return entered_structure().has_value(); }
  /// Returns the guide of a tool with a foot.
  const ToolGuide& guide() const noexcept { return guide_; }
  /// Returns the name and the duration of the job that is computed, such as "cut flap, 3 s so far ..."; empty
  /// if there is no job, or the job began less than 0.3 s ago.
  std::string job_text() const;
  /// Returns the messages to show at the tool: fault_text(), job_text(), the depth of a pushed tool, and the
  /// newest notices.
  std::string notice_text() const;
  /// Returns the most urgent level of these messages.
  workbench::EventLevel notice_level() const;
  Viewport& viewport() noexcept { return viewport_; }
  const std::shared_ptr<const volume::Version>& version() const noexcept { return version_; }
  /// Frozen current state, which later cuts do not change. Waits for the edits, some milliseconds.
  std::shared_ptr<const volume::Version> frozen_version() { return live_.snapshot().get()->undoable.version; }

 private:
  sim::Overlays with_guides(sim::Overlays overlays) const;
  void place_devices();
  /// True if a device has motors, whose force the user must turn on again after a fault.
  bool has_haptic_device() const {
    const auto has_motors = [](const auto& device) { return device && device->capabilities().has_motors(); };
    return has_motors(options_.device) || has_motors(options_.left_device);
  }
  /// Returns the latched faults of all hands.
  std::uint32_t latched_faults() const noexcept;
  void collect_notices();
  std::string depth_text() const;
  std::string push_text() const;
  struct EnteredStructure {
    std::string name;
    double depth = 0;  ///< mm
    std::size_t hand = 0;
    bool is_pushed = false;   ///< it is the dura, intact, and the tool does not cut
    bool is_touched = false;  ///< it is the dura, intact, and the tool cuts
  };
  std::optional<EnteredStructure> entered_structure() const;
  void restore_force();
  /// Shows a message at the tool.
  void add_notice(const char* text, workbench::EventLevel level = workbench::EventLevel::outcome);
  enum class HistoryStep : std::uint8_t { undo, redo };
  void change_history(HistoryStep step);
  bool is_release_processed() const;
  void send_history_steps();
  int body_at_hand() const;
  bool carry_piece(const Ray& ray);
  std::function<bool(const glm::dvec3&)> bone_in(const volume::Version& version) const;
  struct Press {
    glm::dvec3 normal;  ///< unit, out of the bone
    double depth;       ///< mm
  };
  Press press_at(const Ray& ray, double hit) const;
  double press_depth(const Ray& ray, double hit) const;
  void follow_cursor();
  void watch_sight(const Ray& ray, bool is_pressed);
  void watch_progress();
  void watch_flap();
  bool wait_outside_clip(const Ray& ray, double hit);
  double clearance_at(const glm::dvec3& tip, double expected) const;
  bool passes_forbidden(const glm::dvec3& from, const glm::dvec3& to) const;
  double distance_above_soft(const Ray& ray, double along) const;
  std::optional<double> distance_to_forbidden(
      const Ray& ray, double hit, Viewport::Clipping clipping = Viewport::Clipping::applied) const;
  void drag_handle();
  void touch_scenery();
  void follow_instrument_change();
  bool needs_other_balls(const sim::InstrumentType& type, const sim::Value& instrument,
                         std::size_t hand) const;
  double distance_to_bodies(const Ray& ray) const;
  void follow_surface(const Ray& ray, bool is_over_bone, bool is_soft);
  bool follow_guide(const Ray& ray, double hit);
  bool waits_for_bone();
  std::string refusal_text(const Error& error) const;
  bool has_event(std::string_view name) const;
  bool follow_line(const Ray& ray, const ToolAppearance& tool, bool is_pressed);
  std::optional<glm::dvec3> bone_near(const Ray& ray, double hit);
  glm::dvec3 shaft() const { return tilt_ * shaft_; }
  glm::dquat turn_along(const glm::dvec3& shaft) const;

  const haptics::TouchScene* scene_;
  WindowOptions options_;
  Viewport viewport_;
  MouseDevice mouse_;
  PedalButton pedal_;
  std::vector<haptics::Device*> devices_;  ///< by hand
  sim::LiveSession live_;
  sim::LiveState state_;
  std::shared_ptr<const volume::Version> version_;
  glm::dvec3 device_start_{0.0};  ///< position of a device's tool at its start
  double x_ = 0.5, y_ = 0.5;      ///< cursor, see set_cursor()
  bool was_in_picture_ = false;   ///< the cursor, since the start
  double depth_mm_ = 2;
  double reach_ = 300;  ///< last distance of the camera from the surface under the cursor, mm
  int roll_ = 0;        ///< steps of 15 degrees
  std::shared_ptr<const volume::Version> uncut_;  ///< scan without cuts, for the shaft's direction
  glm::dvec3 shaft_{0, 0, 1};                     ///< unit, shaft of the mouse's tool before tilting
  glm::dquat tilt_{1, 0, 0, 0};
  std::vector<volume::Field> solids_;  ///< shapes that count as bone
  ShaftMode shaft_mode_ = ShaftMode::surface;
  ToolGuide guide_;
  /// A piece that the mouse holds.
  struct Carried {
    glm::dvec3 from{0.0};          ///< mm, requested position when the piece was grasped
    double along = 0, lift = 0;    ///< mm: distance of `from` from the viewer; lift toward the viewer
    haptics::Placement hand = {};  ///< the requested pose
    PieceGuard guard;
  };
  std::optional<Carried> carried_;
  LineGuide line_;
  std::vector<LineGuide::Line> planned_lines_;
  std::optional<StepGuide> steps_;
  std::optional<std::size_t> prepared_step_;         ///< the step whose instruments are prepared
  std::chrono::steady_clock::time_point guided_at_;  ///< time of the last update of guide_ or line_
  double guide_refused_at_ = -1e9;                   ///< s, time of the guide's last refusal
  bool is_over_bone_ = false;                        ///< the cursor is over bone
  bool has_drill_stopped_ = false;  ///< the clutch of a perforator released during this press
  /// Cut with the craniotome in the hand, or with the one that was put away: volume removed (mm³) and number
  /// of bodies when it was taken.
  struct FlapCut {
    double removed_mm3 = 0;
    std::size_t bodies = 0;
    double ended_at = -1;  ///< s; -1: the craniotome is in the hand
  };
  std::optional<FlapCut> flap_cut_;
  /// Start (s) of the interval in which watch_progress() measures, and volume removed by then (mm³).
  double progress_at_ = 0, progress_mm3_ = 0;
  bool is_rub_reported_ = false;    ///< it was reported that the burr hardly cuts, and it has not cut since
  double visible_at_ = 0;           ///< s, time of the state in which a pressed tool was last visible
  bool is_hidden_ = false;          ///< a pressed tool slid behind bone
  glm::dvec3 hidden_ray_{0, 1, 0};  ///< direction of the cursor's ray at that time
  bool has_click_ = false;          ///< the button was pressed since the last frame, even if released again
  bool is_tip_held_ = false, is_pressed_ = false, is_finished_ = false, is_started_ = false;
  bool shows_clip_volumes_ = false, shows_workspaces_ = false;
  bool is_face_refused_ = false;     ///< this press on a cut face was refused
  int scenery_ = -1;                 ///< item that is touched by pictures of the view's depth; -1: none
  volume::Camera requested_camera_;  ///< camera, position and mesh of the last depth request
  glm::dvec3 requested_at_{1e9};
  const haptics::MeshTree* requested_mesh_ = nullptr;
  std::uint64_t hidden_pictures_ = 0;     ///< see hidden_pictures()
  std::uint64_t known_depth_serial_ = 0;  ///< serial of the newest depth of the scenery
  /// Position to which the tool is moved when the next picture is adopted, in front of the scenery that it
  /// was in; mm, world.
  std::optional<glm::dvec3> landing_;
  glm::dvec3 request_{0.0};                      ///< requested position in the last frame, mm, world
  glm::dvec3 under_cursor_{0.0};                 ///< point of the surface in the last frame, mm, world
  bool is_lifted_ = true;                        ///< the tool jumps to its next position
  double lifted_radius_ = -1;                    ///< mm, radius of the tool in the last frame
  std::optional<std::size_t> requested_stroke_;  ///< number of strokes of the requested state, until reached
  std::vector<HistoryStep> history_steps_;       ///< steps that wait for the end of a stroke
  std::string refused_;
  Notices notices_;
  std::chrono::steady_clock::time_point started_;
  /// Time at which the fault of a mouse started, or was last reset; nullopt: no fault.
  std::optional<std::chrono::steady_clock::time_point> fault_since_;
  sim::Value dragged_handle_;   ///< command that moves the grasped point; empty: no point
  glm::dvec3 dragged_to_{0.0};  ///< last requested position
  int frames_since_drag_ = 0;
  sim::Value requested_tool_;       ///< instrument that waits for its offset fields; empty: no instrument
  std::size_t requested_hand_ = 0;  ///< hand of requested_tool_
  int frames_without_job_ = 0;      ///< frames without pending jobs since `requested_tool_` was requested
  std::string job_;                 ///< name of the job that is computed
  double job_started_ = 0;          ///< s, start of that job as seconds()
  std::shared_ptr<const sim::Overlays> shown_;  ///< overlays in the picture
  double waits_since_ = -1;                     ///< s, see waits_for_bone(); -1: it does not wait
  std::vector<float> frame_ms_, drilling_ms_;   ///< times of frames, and of frames with a cut
  WindowReport report_;
};

}  // namespace trephine::view
