#include "apps/view/replay_controller.h"

#include <algorithm>
#include <cmath>

#include "apps/view/tool_appearance.h"

namespace trephine::view {

ReplayController::ReplayController(const haptics::TouchScene& scene, sim::Replay& replay, double rate_hz,
                                   double seconds, workbench::SessionSummary summary, vtkRenderWindow* window)
    : replay_(&replay),
      rate_hz_(rate_hz),
      seconds_(seconds),
      summary_(std::move(summary)),
      viewport_(scene, window, true) {
  if (const auto& plan = replay.engine().now().plan; plan && !plan->procedure.is_empty())
    steps_.emplace(plan);
}

void ReplayController::start() {
  viewport_.request_all(replay_->engine().current());
  replay_->take_changed();
}

void ReplayController::set_speed(double speed) { speed_ = std::clamp(speed, 0.1, 100.0); }

double ReplayController::seconds() const { return static_cast<double>(replay_->next_tick()) / rate_hz_; }

Status ReplayController::seek(double seconds) {
  now_ = std::clamp(seconds, 0.0, seconds_);
  return replay_->seek(static_cast<std::uint64_t>(std::llround(now_ * rate_hz_)));
}

Status ReplayController::frame(double elapsed) {
  Status error;
  if (is_playing_) {
    error = seek(now_ + speed_ * elapsed);
    if (now_ >= seconds_) is_playing_ = false;
  }
  if (steps_) steps_->show(replay_->engine().now().undoable.procedure);
  const std::shared_ptr<const volume::Version> version = replay_->engine().current();
  const volume::VoxelBox changed = replay_->take_changed();
  has_changed_ = changed.low.x <= changed.high.x;
  viewport_.request(version, changed);
  const glm::dvec3 viewer = -viewport_.ray_at(0.5, 0.5).direction;
  // Show the tool of that tick.
  viewport_.set_contact_tool(*replay_->engine().tool(static_cast<std::size_t>(hand())).scene->tool);
  if (replay_->next_tick() > 0)
    viewport_.show_stylus(
        record(),
        appearance_of(replay_->engine().now().settings.hands[static_cast<std::size_t>(hand())].parameters),
        *version, viewer);
  if (shown_ != replay_->next_tick()) {  // the engine's overlays include the poses of held bodies
    sim::Overlays overlays = replay_->engine().overlays();
    for (sim::Overlay& overlay : overlays) overlay.holder = -1;
    if (shows_clip_volumes_)
      overlays = with_clip_volumes(std::move(overlays), replay_->engine().displayed_depths(0));
    viewport_.show(overlays, {});
    shown_ = replay_->next_tick();
  }
  viewport_.draw();
  return error;
}

}  // namespace trephine::view
