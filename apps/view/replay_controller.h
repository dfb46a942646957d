// ReplayController: plays a recorded session in a picture, with a speed, a pause and jumps to any time.
#pragma once

#include <algorithm>
#include <memory>
#include <optional>

#include "apps/view/step_guide.h"
#include "apps/view/viewport.h"
#include "apps/workbench/session_summary.h"
#include "sim/drivers/replay.h"

namespace trephine::view {

/// Independent of the windowing toolkit. Drawing thread only. Borrows scene, replay and window.
class ReplayController {
 public:
  /// `rate_hz`, `seconds`: rate and duration of the session. `summary`: active hands and marks of the
  /// session.
  ReplayController(const haptics::TouchScene& scene, sim::Replay& replay, double rate_hz, double seconds,
                   workbench::SessionSummary summary, vtkRenderWindow* window);

  void start();
  void play(bool is_playing) { is_playing_ = is_playing; }
  bool is_playing() const noexcept { return is_playing_; }
  /// Sets the speed relative to real time; limited to 0.1 to 100.
  void set_speed(double speed);
  double speed() const noexcept { return speed_; }
  Status seek(double seconds);
  /// As seek(), but a long way is divided among several frames, which show the previous picture.
  Status begin_seek(double seconds);
  bool is_seeking() const noexcept { return target_.has_value(); }
  /// Time of playback, s. It continues after the end of the session, up to length().
  double seconds() const;
  /// Time at which playback ends: the duration of the session, or a longer one that was set, s.
  double length() const noexcept { return length_; }
  /// Continues the time after the end of the session, for a longer session that is played with this one.
  void set_length(double seconds) { length_ = std::max(seconds, duration_); }
  /// Duration of the session, s.
  double duration() const noexcept { return duration_; }

  /// Draws one frame, `elapsed` s after the last one.
  Status frame(double elapsed);
  /// True if matter changed in the newest frame.
  bool has_changed() const noexcept { return has_changed_; }
  /// Returns the record of the shown tick of the active hand.
  const haptics::ServoRecord& record() const noexcept { return replay_->record(hand()); }
  /// Steps of the session's procedure; null without a procedure.
  const StepGuide* steps() const noexcept { return steps_ ? &*steps_ : nullptr; }
  /// Sets whether the parts of the force of the shown tick are computed and drawn. They are computed only
  /// while the replay is paused.
  void explain_force(bool is_explained);
  /// Parts of the force of the shown tick; nullopt while the replay plays, before the first tick, or if
  /// explain_force() is off.
  const std::optional<haptics::ForceParts>& force_parts() const noexcept { return force_parts_; }
  /// Scene of the hand in the shown tick.
  std::shared_ptr<const haptics::TouchScene> touch_scene() const { return replay_->servo_hand()->scene; }
  /// Goes some ticks forward or back.
  Status step(int ticks);
  int hand() const noexcept { return summary_.hand_at(replay_->next_tick()); }
  const workbench::SessionSummary& summary() const noexcept { return summary_; }
  const sim::Engine& engine() const { return replay_->engine(); }
  Viewport& viewport() noexcept { return viewport_; }
  /// Shows or hides the clip volumes of depth images.
  void show_clip_volumes(bool are_shown) {
    if (are_shown != shows_clip_volumes_) shown_.reset();
    shows_clip_volumes_ = are_shown;
  }

 private:
  sim::Replay* replay_;
  double rate_hz_, duration_, length_;
  workbench::SessionSummary summary_;
  Viewport viewport_;
  std::optional<StepGuide> steps_;
  void update_force_parts();

  bool has_picture_ = false;  ///< the whole anatomy is computed; the replay plays from then on
  bool is_playing_ = true, has_changed_ = false, shows_clip_volumes_ = false, is_force_explained_ = false;
  std::optional<haptics::ForceParts> force_parts_;
  std::uint64_t explained_tick_ = 0;  ///< next_tick() for which `force_parts_` was computed; 0: no tick
  double speed_ = 1, now_ = 0;
  std::optional<std::uint64_t> target_;  ///< tick to which the frames continue to seek
  /// Continues toward `target_` for a part of a frame.
  Status continue_seeking();
  std::uint64_t tick_at_now() const;
  std::optional<std::uint64_t> shown_;  ///< next_tick() of the replay when the overlays were shown
  std::ptrdiff_t pieces_ = 0;           ///< detached pieces that the overlays show
};

}  // namespace trephine::view
