#include "sim/live_session.h"

#include <array>
#include <chrono>
#include <deque>
#include <iterator>

namespace trephine::sim {

LiveSession::LiveSession(haptics::Device& device, const haptics::TouchScene& scene,
                         const haptics::ProxyMethod& method, Tool* tool, const haptics::ServoOptions& options,
                         SessionWriter* recorder)
    : LiveSession(std::array{&device}, EditSession(scene, method, tool, 1 / options.rate_hz), options,
                  recorder) {}

LiveSession::LiveSession(std::span<haptics::Device* const> devices, EditSession edits,
                         const haptics::ServoOptions& options, SessionWriter* recorder,
                         std::uint64_t first_tick)
    : edits_(std::move(edits)),
      channel_(edits_.servo_scene()),
      servo_(devices, channel_, options, first_tick),
      recorder_(recorder),
      wants_realtime_(options.wants_realtime) {
  TREPHINE_ASSERT(devices.size() == edits_.hand_count());
  state_.hands.resize(devices.size());
  noted_faults_.resize(devices.size());
  const std::lock_guard guard(lock_);
  note({true, {glm::ivec3(0), glm::ivec3(-1)}});
}

LiveSession::~LiveSession() { stop(); }

volume::Status LiveSession::start() {
  if (volume::Status error = servo_.start()) return error;
  is_stopping_ = false;
  if (edits_.scene().tool_radius > 0) {
    offsets_.is_stopping = offsets_.is_busy = false;
    offset_thread_ = std::thread([this] { make_offsets(); });
  }
  thread_ = std::thread([this] { run(); });
  return std::nullopt;
}

void LiveSession::stop() {
  servo_.stop();
  is_stopping_ = true;
  if (thread_.joinable()) thread_.join();
  if (!offset_thread_.joinable()) return;
  {
    const std::lock_guard guard(offsets_.lock);
    offsets_.is_stopping = true;
  }
  offsets_.news.notify_one();
  offset_thread_.join();
  offsets_.job = std::nullopt;
  offsets_.made = std::nullopt;
}

/// Offset thread: one job after another.
void LiveSession::make_offsets() {
  std::unique_lock guard(offsets_.lock);
  for (;;) {
    offsets_.news.wait(guard, [this] { return offsets_.job || offsets_.is_stopping; });
    if (offsets_.is_stopping) return;
    std::optional<OffsetJob> job = std::exchange(offsets_.job, std::nullopt);
    guard.unlock();
    const auto begin = std::chrono::steady_clock::now();
    OffsetJob::Offsets made = job->make(edits_.scene());
    job.reset();  // perhaps the last to hold a version: freed while nobody waits
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    guard.lock();
    offsets_.made = std::move(made);
    offsets_.longest_seconds = std::max(offsets_.longest_seconds, seconds);
    ++offsets_.count;
  }
}

/// Edit thread: attaches what was made, and asks for more. What was made of a state that was undone since is
/// left.
void LiveSession::take_offsets() {
  std::optional<OffsetJob::Offsets> made;
  {
    const std::lock_guard guard(offsets_.lock);
    if (offsets_.is_busy && !offsets_.made) return;
    made = std::exchange(offsets_.made, std::nullopt);
    offsets_.is_busy = false;
  }
  if (made) {
    const EditOutcome outcome = edits_.attach(offsets_.serial, std::move(*made));
    if (outcome.is_changed) {
      channel_.publish(edits_.servo_scene());
      const Command command{Command::Kind::offsets, 0, {}, static_cast<double>(offsets_.serial)};
      if (recorder_) recorder_->add(command, edits_, outcome);
      const std::lock_guard guard(lock_);
      note(outcome);
    }
  }
  std::optional<OffsetJob> job = edits_.offset_job();
  if (!job) return;
  offsets_.serial = job->version->serial();
  {
    const std::lock_guard guard(offsets_.lock);
    offsets_.job = std::move(job);
    offsets_.is_busy = true;
  }
  offsets_.news.notify_one();
}

LiveSession::OffsetReport LiveSession::offset_report() {
  const std::lock_guard guard(offsets_.lock);
  return {offsets_.count, offsets_.longest_seconds};
}

void LiveSession::run() {
  // Before ordinary threads, behind the servo: late edits are felt too.
  if (wants_realtime_) haptics::request_realtime(40);
  haptics::ServoRecord record;
  std::deque<Command> commands;
  std::vector<std::pair<std::size_t, glm::dvec3>> landings;
  for (;;) {
    const bool is_last_round = is_stopping_.load();
    bool was_busy = false;
    for (int i = 0; i < 256 && servo_.records().pop(record); ++i) {
      consume(record);
      was_busy = true;
    }
    {
      const std::lock_guard guard(lock_);
      commands.insert(commands.end(), std::make_move_iterator(commands_.begin()),
                      std::make_move_iterator(commands_.end()));
      commands_.clear();
      landings.swap(landings_);
    }
    for (; !commands.empty(); commands.pop_front()) carry_out(commands.front());
    if (wants_reset_.exchange(false)) {
      servo_.request_reset();
      for (std::size_t h = 0; h < edits_.hand_count(); ++h)
        if (const glm::dvec3* free = edits_.last_free(h)) servo_.request_restart(*free, h);
    }
    if (edits_.scene().tool_radius > 0 && !is_last_round) take_offsets();
    for (const auto& [hand, place] : landings) servo_.request_restart(place, hand);
    landings.clear();
    if (is_last_round && !was_busy) return;
    if (!was_busy) std::this_thread::sleep_for(std::chrono::microseconds(200));
  }
}

void LiveSession::consume(const haptics::ServoRecord& record) {
  const EditOutcome outcome = edits_.consume(record);
  if (outcome.is_changed) channel_.publish(edits_.servo_scene());
  if (recorder_) recorder_->add(record, edits_, outcome);
  // A fault is an event of the session.
  std::uint32_t& noted = noted_faults_[record.hand];
  const std::uint32_t latched = record.faults & haptics::k_latched_faults, fresh = latched & ~noted;
  if (fresh != 0) carry_out({Command::Kind::note, record.hand, "fault: " + haptics::fault_names(fresh), 0});
  if (latched == 0 && noted != 0) carry_out({Command::Kind::note, record.hand, "faults cleared", 0});
  noted = latched;
  if (trace_.size() < trace_limit_) trace_.push_back(record);
  const std::lock_guard guard(lock_);
  state_.hands[record.hand] = record;
  if (record.hand == 0) state_.newest = record;
  note(outcome);
}

void LiveSession::carry_out(const Command& command) {
  const EditOutcome outcome = edits_.apply(command);
  if (outcome.is_changed) channel_.publish(edits_.servo_scene());
  if (recorder_) recorder_->add(command, edits_, outcome);
  const std::lock_guard guard(lock_);
  note(outcome);
}

void LiveSession::apply(Command command) {
  const std::lock_guard guard(lock_);
  commands_.push_back(std::move(command));
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

void LiveSession::set_down(const glm::dvec3& free_point_volume, std::size_t hand) {
  const std::lock_guard guard(lock_);
  landings_.emplace_back(hand, free_point_volume);
}

LiveState LiveSession::look() {
  const std::lock_guard guard(lock_);
  LiveState copy = state_;
  state_.changed = {glm::ivec3(0), glm::ivec3(-1)};
  return copy;
}

}  // namespace trephine::sim
