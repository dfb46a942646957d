#include "sim/drivers/live_session.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <deque>
#include <iterator>
#include <sys/resource.h>
#include <unistd.h>

#include "sim/drivers/issued_commands.h"

namespace trephine::sim {

namespace {
using Clock = std::chrono::steady_clock;
double seconds_since(Clock::time_point begin) {
  return std::chrono::duration<double>(Clock::now() - begin).count();
}

Priority priority_of(DerivedKind kind) noexcept {
  switch (kind) {
    case DerivedKind::depth_images:
    case DerivedKind::depth_picture:
      return Priority::depths;
    case DerivedKind::offset_fields:
      return Priority::fields;
    case DerivedKind::loose_parts:
      break;
  }
  return Priority::search;
}
}  // namespace

LiveSession::LiveSession(haptics::Device& device, const haptics::TouchScene& scene,
                         const haptics::ProxyMethod& method, Instrument instrument,
                         const haptics::ServoOptions& options, SessionWriter* recorder)
    : LiveSession(std::array{&device}, Engine(scene, method, std::move(instrument), 1 / options.rate_hz),
                  options, recorder) {}

LiveSession::LiveSession(std::span<haptics::Device* const> devices, Engine engine,
                         const haptics::ServoOptions& options, SessionWriter* recorder,
                         std::uint64_t first_tick)
    : engine_(std::move(engine)),
      channel_(engine_.servo_scene()),
      servo_(devices, channel_, options, first_tick),
      recorder_(recorder),
      wants_realtime_(options.wants_realtime) {
  TREPHINE_ASSERT(devices.size() == engine_.hand_count());
  state_.hands.resize(devices.size());
  state_.tools.resize(devices.size());
  if (recorder_) recorder_->begin(engine_, options.force, options.rate_hz, first_tick, false);
  const std::lock_guard guard(lock_);
  update_tools();
  Outcome first;
  first.is_changed = true;
  update_state(first);
}

LiveSession::~LiveSession() { stop(); }

Status LiveSession::start() {
  if (Status error = servo_.start()) return error;
  is_stopping_ = false;
  {
    const std::lock_guard guard(lock_);
    is_running_ = true;
  }
  Outcome start;
  start.next_commands = engine_.take_initial_commands();
  issue_next(start, false);
  for (const PendingJob& job : engine_.jobs()) begin(job);  // of the first step, or of a continued session
  thread_ = std::thread([this] { run(); });
  return std::nullopt;
}

void LiveSession::stop() {
  servo_.stop();
  is_stopping_ = true;
  if (thread_.joinable()) thread_.join();
  background_.stop();
  // Handles the requests that arrived during the last round.
  std::vector<Command> commands;
  std::vector<std::promise<std::shared_ptr<const OperationState>>> snapshots;
  std::vector<std::pair<std::size_t, std::promise<std::vector<HistoryState>>>> history_states;
  decltype(reason_requests_) reasons;
  {
    const std::lock_guard guard(lock_);
    if (!std::exchange(is_running_, false)) return;
    commands.swap(commands_);
    snapshots.swap(snapshots_);
    history_states.swap(state_requests_);
    reasons.swap(reason_requests_);
  }
  for (const Command& command : commands) carry_out(command, false);
  for (auto& [requests, promise] : reasons) promise.set_value(reasons_now(requests));
  for (auto& promise : snapshots) promise.set_value(engine_.snapshot());
  for (auto& [max_count, promise] : history_states) promise.set_value(history_states_now(max_count));
}

std::vector<LiveSession::HistoryState> LiveSession::history_states_now(std::size_t max_count) {
  engine_.freeze();
  std::vector<HistoryState> result{{"the uncut bone", engine_.uncut()}};
  const Branch& branch = engine_.branch();
  const std::size_t count = branch.history.size();
  for (std::size_t i = 0; i < count; ++i) {
    const bool is_current = i == branch.position;
    if (i + max_count < count && !is_current) continue;
    const std::size_t stroke = branch.final_strokes + i;
    if (stroke == 0 && !is_current) continue;
    if (const auto state = branch.history[i]->state())
      result.push_back({stroke == 0 ? "before the first change" : "change " + std::to_string(stroke),
                        is_current ? engine_.version() : state.value().undoable.version, is_current});
  }
  for (const Branch& other : engine_.other_branches())
    if (const auto state = other.history[other.position]->state())
      result.push_back({"branch " + other.name, state.value().undoable.version});
  return result;
}

/// Edit thread: adopts results of background work, and starts further work. Results of states that were
/// undone are discarded.
void LiveSession::handle_results() {
  for (const Background::Result& adopt : background_.fetch_results()) adopt();
  for (const DerivedKind kind : {DerivedKind::depth_images, DerivedKind::offset_fields}) {
    if (!background_.is_idle(priority_of(kind))) continue;
    std::optional<DerivedJob> job;
    if (kind == DerivedKind::depth_images) job = take_picture();
    if (!job) job = engine_.derived_job(kind);
    if (job) derive(std::move(*job));
  }
  prepare_next();
}

void LiveSession::submit_picture(haptics::depth::DepthPicture picture, std::int64_t item,
                                 const glm::dvec3& touch, double edge, std::uint8_t hand) {
  std::function<DerivedJob()> job = [this, picture = std::move(picture), item, touch, edge, hand] {
    return engine_.picture_job(picture, item, touch, edge, hand);
  };
  const std::lock_guard guard(lock_);
  picture_ = std::move(job);
}

void LiveSession::prepare_instruments(std::vector<TakeInstrument> instruments, std::size_t hand) {
  const std::lock_guard guard(lock_);
  preparations_.clear();
  for (TakeInstrument& instrument : instruments) preparations_.emplace_back(std::move(instrument), hand);
}

/// Edit thread: begins the preparation of the next instrument.
void LiveSession::prepare_next() {
  if (!background_.is_idle(Priority::preparation)) return;
  std::pair<TakeInstrument, std::size_t> next;
  {
    const std::lock_guard guard(lock_);
    if (preparations_.empty()) return;
    next = std::move(preparations_.front());
    preparations_.pop_front();
  }
  auto work = engine_.preparation_of(next.first, next.second);
  if (!work) return;
  background_.submit(Priority::preparation, [this, work = std::move(work)]() -> Background::Result {
    // A thread cannot raise its priority again, so that one of its own is used. With nice value 3 it has a
    // third of a core that a display saturates: a hand that takes the instrument waits for this work.
    std::jthread([&] {
      constexpr int k_low = 3;
      setpriority(PRIO_PROCESS, static_cast<id_t>(gettid()), k_low);
      work(is_stopping_);
    }).join();
    return {};
  });
}

/// Removes the pending picture and returns its job; empty if there is no picture.
std::optional<DerivedJob> LiveSession::take_picture() {
  std::function<DerivedJob()> picture;
  {
    const std::lock_guard guard(lock_);
    picture.swap(picture_);
  }
  return picture ? std::optional(picture()) : std::nullopt;
}

/// Derives data in the background; the edit thread adopts them by a recorded command.
void LiveSession::derive(DerivedJob job) {
  const Priority priority = priority_of(job.key.kind);
  background_.submit(priority, [this, job = std::move(job)]() mutable -> Background::Result {
    const auto begun_at = Clock::now();
    DerivedData data = job.make(1);
    job.make = {};  // may own the last reference to a version, which is freed on this thread
    const double seconds = seconds_since(begun_at);
    {
      const std::lock_guard guard(lock_);
      DerivedReport& report = derived_reports_[static_cast<std::size_t>(job.key.kind)];
      report.longest_seconds = std::max(report.longest_seconds, seconds);
      report.late += seconds > job.interval;
      ++report.count;
    }
    return [this, job = std::move(job), data = std::move(data)] {
      if (job.key.kind == DerivedKind::loose_parts) return end_search(!data.is_empty);
      if (!data.is_empty) carry_out(engine_.submit_result(job, data));
    };
  });
}

LiveSession::DerivedReport LiveSession::derived_report(DerivedKind kind) {
  const std::lock_guard guard(lock_);
  return derived_reports_[static_cast<std::size_t>(kind)];
}

/// Runs a job in the background; the edit thread adopts its result by a recorded command.
void LiveSession::begin(const PendingJob& job) {
  background_.submit(Priority::jobs, [this, job]() -> Background::Result {
    return [this, id = job.id, result = job.run()] {
      const std::vector<PendingJob>& all = engine_.jobs();
      if (std::none_of(all.begin(), all.end(), [&](const PendingJob& one) { return one.id == id; }))
        return;  // the job was cancelled while it ran
      engine_.submit_result(id, result);
      carry_out(AdoptJob{id, static_cast<std::int64_t>(result->hash())});
    };
  });
}

std::future<std::shared_ptr<const OperationState>> LiveSession::snapshot() {
  const std::lock_guard guard(lock_);
  auto& promise = snapshots_.emplace_back();
  auto answer = promise.get_future();
  if (!is_running_) {
    promise.set_value(engine_.snapshot());
    snapshots_.pop_back();
  }
  return answer;
}

std::future<std::vector<LiveSession::HistoryState>> LiveSession::history_states(std::size_t max_count) {
  const std::lock_guard guard(lock_);
  auto& [count, promise] = state_requests_.emplace_back(max_count, std::promise<std::vector<HistoryState>>());
  auto answer = promise.get_future();
  if (!is_running_) {
    promise.set_value(history_states_now(max_count));
    state_requests_.pop_back();
  }
  return answer;
}

std::vector<Status> LiveSession::reasons_now(const std::vector<Command>& commands) const {
  std::vector<Status> reasons;
  for (const Command& command : commands) reasons.push_back(engine_.reason_to_refuse(command));
  return reasons;
}

std::future<std::vector<Status>> LiveSession::reasons_to_refuse(std::vector<Command> commands) {
  const std::lock_guard guard(lock_);
  auto& [requests, promise] =
      reason_requests_.emplace_back(std::move(commands), std::promise<std::vector<Status>>());
  auto answer = promise.get_future();
  if (!is_running_) {
    promise.set_value(reasons_now(requests));
    reason_requests_.pop_back();
  }
  return answer;
}

void LiveSession::run() {
  // Priority above ordinary threads and below the servo, since late edits are perceived too.
  if (wants_realtime_) haptics::request_realtime(40);
  haptics::ServoRecord record;
  std::deque<Command> commands;
  std::vector<std::pair<std::size_t, glm::dvec3>> teleports;
  std::vector<std::promise<std::shared_ptr<const OperationState>>> snapshots;
  std::vector<std::pair<std::size_t, std::promise<std::vector<HistoryState>>>> history_states;
  decltype(reason_requests_) reasons;
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
      teleports.swap(pending_teleports_);
      snapshots.swap(snapshots_);
      history_states.swap(state_requests_);
      reasons.swap(reason_requests_);
    }
    for (; !commands.empty(); commands.pop_front()) carry_out(commands.front());
    if (wants_reset_.exchange(false)) {
      servo_.request_reset();
      for (std::size_t h = 0; h < engine_.hand_count(); ++h)
        if (const glm::dvec3* free = engine_.last_free(h)) servo_.request_restart(*free, h);
    }
    if (!is_last_round) handle_results();
    for (auto& promise : snapshots) promise.set_value(engine_.snapshot());
    snapshots.clear();
    for (auto& [max_count, promise] : history_states) promise.set_value(history_states_now(max_count));
    history_states.clear();
    for (auto& [requests, promise] : reasons) promise.set_value(reasons_now(requests));
    reasons.clear();
    for (const auto& [hand, position] : teleports) servo_.request_restart(position, hand);
    teleports.clear();
    if (is_last_round && !was_busy) return;
    if (!was_busy) std::this_thread::sleep_for(std::chrono::microseconds(200));
  }
}

LiveSession::EditReport LiveSession::edit_report() {
  const std::lock_guard guard(lock_);
  return edit_report_;
}

void LiveSession::consume(const haptics::ServoRecord& record) {
  const auto begin = Clock::now();
  const Outcome outcome = engine_.apply(record);
  const double seconds = seconds_since(begin);
  if (outcome.is_changed) channel_.publish(engine_.servo_scene());
  if (recorder_) recorder_->add(record, engine_, outcome);
  if (trace_.size() < trace_limit_) trace_.push_back(record);
  update_overlays(outcome, false);
  {
    const std::lock_guard guard(lock_);
    edit_report_.longest_tick_seconds = std::max(edit_report_.longest_tick_seconds, seconds);
    state_.hands[record.hand] = record;
    if (record.hand == 0) state_.newest = record;
    update_state(outcome);
  }
  issue_next(outcome, true);
  if (!pieces_) return;
  const PieceWatch::Detection found = pieces_->after_tick(engine_);
  if (found == PieceWatch::Detection::disconnected) free_pieces();
  if (found != PieceWatch::Detection::pending) return;
  // The whole volume is searched in the background. Later cuts can only disconnect further parts.
  {
    const std::lock_guard guard(lock_);
    state_.is_searching_pieces = true;
  }
  derive(pieces_->search(engine_));
}

/// Ends a search for disconnected parts, with or without a finding.
void LiveSession::end_search(bool has_found) {
  if (has_found) free_pieces();
  const std::lock_guard guard(lock_);
  state_.is_searching_pieces = false;
}

/// Detaches free pieces by an internal command, whose refusal is not reported.
void LiveSession::free_pieces() {
  std::optional<Error> unread;  // refusal of a user's command that no display has fetched
  {
    const std::lock_guard guard(lock_);
    unread = state_.refused;
  }
  if (!carry_out(pieces_->command()).refused) return;
  const std::lock_guard guard(lock_);
  state_.refused = std::move(unread);
}

Outcome LiveSession::carry_out(const Command& command, bool may_begin) {
  Outcome outcome = carry_out_alone(command, may_begin);
  issue_next(outcome, may_begin);
  return outcome;
}

/// Carries out the commands that steps issue.
void LiveSession::issue_next(const Outcome& outcome, bool may_begin) {
  issue(outcome.next_commands,
        [&](const Command& command) { return std::move(carry_out_alone(command, may_begin).next_commands); });
}

Outcome LiveSession::carry_out_alone(const Command& command, bool may_begin) {
  const auto begun_at = Clock::now();
  Outcome outcome = engine_.apply(command);
  const double seconds = seconds_since(begun_at);
  if (outcome.is_changed) channel_.publish(engine_.servo_scene());
  if (recorder_) recorder_->add(command, engine_, outcome);
  if (pieces_) pieces_->after_command(engine_, command, outcome);
  if (may_begin && !engine_.jobs().empty() && engine_.jobs().back().id == outcome.job)
    begin(engine_.jobs().back());
  update_overlays(outcome, true);
  const std::lock_guard guard(lock_);
  if (seconds > edit_report_.longest_command_seconds) {
    edit_report_.longest_command_seconds = seconds;
    edit_report_.longest_command = command.request.is_empty() ? "" : command.request.name();
  }
  update_tools();  // ticks do not change them
  update_state(outcome);
  return outcome;
}

void LiveSession::apply(Command command) {
  const std::lock_guard guard(lock_);
  commands_.push_back(std::move(command));
}

/// Edit thread: makes new overlays if a display has fetched the state since the last ones, and overlays may
/// have changed.
void LiveSession::update_overlays(const Outcome& outcome, bool is_command) {
  has_new_overlays_ = has_new_overlays_ || is_command || outcome.is_changed || outcome.event_count > 0 ||
                      (is_state_requested_ && engine_.has_moving_surfaces());
  if (!has_new_overlays_ || !is_state_requested_.exchange(false)) return;
  has_new_overlays_ = false;
  auto overlays = std::make_shared<const Overlays>(engine_.overlays());
  // Measuring the size of the history traverses the whole history. It is measured only after a stroke or a
  // change of branch.
  std::optional<std::size_t> bytes;
  if (!engine_.is_in_stroke() && (engine_.stroke_count() != strokes_at_memory_count_ ||
                                  engine_.branch().name != branch_at_memory_count_)) {
    strokes_at_memory_count_ = engine_.stroke_count(), branch_at_memory_count_ = engine_.branch().name;
    bytes = engine_.history_bytes();
  }
  const std::lock_guard guard(lock_);
  if (bytes) state_.history_bytes = *bytes;
  state_.overlays = std::move(overlays);
  state_.depths = engine_.displayed_depths(0);
  state_.settings = engine_.state().settings.modules;
  state_.bodies.clear();
  for (const Body& body : engine_.state().undoable.bodies) state_.bodies.push_back(body.id);
}

void LiveSession::update_tools() {
  for (std::size_t h = 0; h < state_.tools.size(); ++h)
    state_.tools[h].parameters = engine_.state().settings.hands[h].parameters;
  state_.tool = state_.tools[0].parameters;
}

void LiveSession::update_state(const Outcome& outcome) {
  if (outcome.refused) state_.refused = outcome.refused;
  if (outcome.failed) state_.failed = outcome.failed;
  if (outcome.event_count > 0) {
    const Chronicle& chronicle = engine_.state().chronicle;
    for (std::size_t i = chronicle.size() - outcome.event_count; i < chronicle.size(); ++i)
      state_.events.push_back(chronicle[i]);
    if (state_.events.size() > LiveState::k_max_events)
      state_.events.erase(state_.events.begin(), state_.events.end() - LiveState::k_max_events);
  }
  if (outcome.is_changed) {
    state_.version = engine_.version();
    state_.changed = union_of(state_.changed, outcome.box);
  }
  state_.watches.assign(engine_.state().watches.begin(), engine_.state().watches.end());
  state_.removed_mm3 = engine_.removed_mm3();
  const std::vector<PendingJob>& jobs = engine_.jobs();
  state_.pending_jobs = jobs.size();
  state_.job = jobs.empty() ? std::string() : std::string(jobs.front().parameters->name());
  state_.tool_radius = engine_.tool(0).scene->tool->radius();
  for (std::size_t h = 0; h < state_.tools.size(); ++h) state_.tools[h].contact = engine_.tool(h).scene->tool;
  state_.strokes = engine_.stroke_count();
  const Branch& branch = engine_.branch();
  state_.first_stroke = branch.final_strokes;
  state_.all_strokes = branch.final_strokes + branch.history.size() - 1;
  const std::vector<Branch>& others = engine_.other_branches();
  if (state_.branch != branch.name || state_.branches.size() != others.size()) {
    state_.branch = branch.name;
    state_.branches.clear();
    for (const Branch& other : others) state_.branches.push_back(other.name);
  }
  state_.can_undo = engine_.can_undo();
  state_.can_redo = engine_.can_redo();
  state_.step = engine_.state().undoable.procedure.step;
  state_.step_tick = engine_.state().undoable.procedure.entered_tick;
  state_.step_visits = engine_.state().undoable.procedure.visits;
}

void LiveSession::teleport_tool(const glm::dvec3& free_point_volume, std::size_t hand) {
  const std::lock_guard guard(lock_);
  pending_teleports_.emplace_back(hand, free_point_volume);
}

LiveState LiveSession::fetch_state() {
  is_state_requested_ = true;
  const std::lock_guard guard(lock_);
  LiveState copy = state_;
  state_.changed = k_no_voxels;
  state_.refused.reset();
  state_.failed.reset();
  state_.events.clear();
  return copy;
}

}  // namespace trephine::sim
