#include "apps/view/replay_controller.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "apps/view/tool_appearance.h"
#include "apps/workbench/force_text.h"

namespace trephine::view {

ReplayController::ReplayController(const haptics::TouchScene& scene, sim::Replay& replay, double rate_hz,
                                   double seconds, workbench::SessionSummary summary, vtkRenderWindow* window)
    : replay_(&replay),
      rate_hz_(rate_hz),
      duration_(seconds),
      length_(seconds),
      summary_(std::move(summary)),
      viewport_(scene, window, true) {
  if (const auto& plan = replay.engine().state().plan; plan && !plan->procedure.is_empty())
    steps_.emplace(plan);
}

void ReplayController::start() {
  viewport_.request_all(replay_->engine().version());
  replay_->take_changed();
}

void ReplayController::set_speed(double speed) { speed_ = std::clamp(speed, 0.1, 100.0); }

double ReplayController::seconds() const {
  return now_ > duration_ || target_ ? now_ : static_cast<double>(replay_->next_tick()) / rate_hz_;
}

Status ReplayController::seek(double seconds) {
  now_ = std::clamp(seconds, 0.0, length_);
  target_.reset();
  return replay_->seek(tick_at_now());
}

Status ReplayController::begin_seek(double seconds) {
  now_ = std::clamp(seconds, 0.0, length_);
  target_ = tick_at_now();
  return continue_seeking();
}

std::uint64_t ReplayController::tick_at_now() const {
  return static_cast<std::uint64_t>(std::llround(std::min(now_, duration_) * rate_hz_));
}

Status ReplayController::continue_seeking() {
  constexpr double k_part = 0.1;  // s, after which the window answers again
  const Result<bool> has_arrived = replay_->seek_for(*target_, k_part);
  if (!has_arrived || has_arrived.value()) target_.reset();
  return has_arrived ? std::nullopt : Status(has_arrived.error());
}

Status ReplayController::step(int ticks) {
  is_playing_ = false;
  return seek(seconds() + ticks / rate_hz_);
}

void ReplayController::explain_force(bool is_explained) {
  if (std::exchange(is_force_explained_, is_explained) == is_explained) return;
  force_parts_.reset();
  explained_tick_ = 0;
  shown_.reset();
}

void ReplayController::update_force_parts() {
  if (!is_force_explained_) return;
  const std::uint64_t next = replay_->next_tick();
  if (is_playing_ || next == 0) {  // 0: before the first tick
    if (force_parts_) shown_.reset();
    force_parts_.reset();
    explained_tick_ = 0;
    return;
  }
  if (explained_tick_ == next) return;
  explained_tick_ = next;
  auto parts = replay_->force_parts(next - 1, hand());
  force_parts_.reset();
  if (parts) force_parts_ = std::move(parts).value();
  // Replay the other hands of the tick. The replay was at `next` before, so this does not fail.
  (void)replay_->seek(next);
  shown_.reset();
}

Status ReplayController::frame(double elapsed) {
  Status error;
  has_picture_ = has_picture_ || viewport_.is_whole();
  if (target_) {
    if (Status failed = continue_seeking()) return failed;
    if (target_) {
      viewport_.draw();
      return std::nullopt;
    }
  } else if (is_playing_ && has_picture_) {
    error = seek(now_ + speed_ * elapsed);
    if (now_ >= length_) is_playing_ = false;
  }
  if (steps_) steps_->show(replay_->engine().state().undoable.procedure);
  const std::shared_ptr<const volume::Version> version = replay_->engine().version();
  const volume::VoxelBox changed = replay_->take_changed();
  has_changed_ = changed.low.x <= changed.high.x;
  viewport_.request(version, changed);
  const glm::dvec3 viewer = -viewport_.ray_at(0.5, 0.5).direction;
  // Show the tool of the current tick.
  viewport_.set_contact_tool(*replay_->engine().tool(static_cast<std::size_t>(hand())).scene->tool);
  if (replay_->next_tick() == 0)
    viewport_.view().show(StylusState{.is_visible = false});
  else
    viewport_.show_stylus(
        record(),
        appearance_of(replay_->engine().state().settings.hands[static_cast<std::size_t>(hand())].parameters),
        *version, viewer);
  update_force_parts();
  if (shown_ != replay_->next_tick()) {  // the engine's overlays are already at the poses of held bodies
    sim::Overlays overlays = replay_->engine().overlays();
    for (sim::Overlay& overlay : overlays) overlay.holder = -1;
    if (shows_clip_volumes_)
      overlays = with_clip_volumes(std::move(overlays), replay_->engine().displayed_depths(0));
    if (force_parts_) overlays.push_back(workbench::force_lines(*force_parts_, *touch_scene()));
    // A piece that was detached in the meantime is drawn when the bone is drawn without it.
    const auto pieces = std::count_if(overlays.begin(), overlays.end(),
                                      [](const sim::Overlay& overlay) { return overlay.is_detached; });
    if (pieces <= pieces_ || viewport_.is_whole()) {
      viewport_.show(overlays, {});
      shown_ = replay_->next_tick();
      pieces_ = pieces;
    }
  }
  viewport_.draw();
  return error;
}

}  // namespace trephine::view
