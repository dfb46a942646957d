#include "sim/live_session.h"

#include <chrono>

namespace trephine::sim {

LiveSession::LiveSession(haptics::Device& device, const haptics::TouchScene& scene,
                         const haptics::ProxyMethod& method, Tool* tool, const haptics::ServoOptions& options)
    : scene_(&scene),
      edits_(scene, tool, 1 / options.rate_hz),
      channel_(edits_.current()),
      servo_(device, channel_, scene, method, options) {
  state_.version = edits_.current();
}

LiveSession::~LiveSession() { stop(); }

volume::Status LiveSession::start() {
  if (volume::Status error = servo_.start()) return error;
  is_stopping_ = false;
  thread_ = std::thread([this] { run(); });
  return std::nullopt;
}

void LiveSession::stop() {
  servo_.stop();
  is_stopping_ = true;
  if (thread_.joinable()) thread_.join();
}

void LiveSession::run() {
  haptics::ServoRecord record;
  for (;;) {
    const bool is_last_round = is_stopping_.load();
    bool was_busy = false;
    while (servo_.records().pop(record)) {
      consume(record);
      was_busy = true;
    }
    for (int left = requests_.exchange(0); left > 0;) {
      const bool is_redo = left >= 1 << 16;
      travel(is_redo);
      left -= is_redo ? 1 << 16 : 1;
    }
    if (wants_reset_.exchange(false)) {
      servo_.request_reset();
      if (const glm::dvec3* free = edits_.last_free(places_)) servo_.request_restart(*free);
    }
    std::optional<glm::dvec3> landing;
    {
      const std::lock_guard guard(lock_);
      landing.swap(landing_);
    }
    if (landing) servo_.request_restart(*landing);
    if (is_last_round) return;
    if (!was_busy) std::this_thread::sleep_for(std::chrono::microseconds(200));
  }
}

void LiveSession::consume(const haptics::ServoRecord& record) {
  if ((record.faults & haptics::k_latched_faults) == 0)
    remember_place(places_, scene_->base->frame.volume_from_world(record.proxy_world));
  const EditOutcome outcome = edits_.consume(record);
  if (outcome.is_changed) channel_.publish(edits_.current());
  if (trace_.size() < trace_limit_) trace_.push_back(record);
  const std::lock_guard guard(lock_);
  state_.newest = record;
  note(outcome);
}

void LiveSession::note(const EditOutcome& outcome) {
  if (outcome.is_changed) {
    state_.version = edits_.current();
    state_.changed = united(state_.changed, outcome.box);
  }
  state_.removed_mm3 = edits_.removed_mm3();
  state_.strokes = edits_.stroke_count();
  state_.can_undo = edits_.can_undo();
  state_.can_redo = edits_.can_redo();
}

void LiveSession::travel(bool is_redo) {
  const EditOutcome outcome = is_redo ? edits_.redo() : edits_.undo();
  if (!outcome.is_changed) return;
  // The version first: a proxy set free before it would walk back into the hole that is about to close.
  channel_.publish(edits_.current());
  if (const glm::dvec3* free = edits_.last_free(places_)) servo_.request_restart(*free);
  const std::lock_guard guard(lock_);
  note(outcome);
}

void LiveSession::set_down(const glm::dvec3& free_point_volume) {
  const std::lock_guard guard(lock_);
  landing_ = free_point_volume;
}

LiveState LiveSession::look() {
  const std::lock_guard guard(lock_);
  LiveState copy = state_;
  state_.changed = {glm::ivec3(0), glm::ivec3(-1)};
  return copy;
}

}  // namespace trephine::sim
