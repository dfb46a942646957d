#include "sim/drivers/lockstep.h"

#include <algorithm>

#include "sim/drivers/issued_commands.h"

namespace trephine::sim {

namespace {
/// Adds the changes of another tick or command.
void add(Outcome& sum, const Outcome& part) {
  sum.is_edit |= part.is_edit;
  sum.is_changed |= part.is_changed;
  sum.box = union_of(sum.box, part.box);
  sum.event_count += part.event_count;
}
}  // namespace

Lockstep::Lockstep(const haptics::TouchScene& scene, const haptics::ProxyMethod& method,
                   Instrument instrument, const haptics::ForceOptions& force, double rate_hz,
                   SessionWriter* recorder)
    : Lockstep(Engine(scene, method, std::move(instrument), 1 / rate_hz), force, rate_hz, recorder) {}

Lockstep::Lockstep(Engine engine, const haptics::ForceOptions& force, double rate_hz, SessionWriter* recorder,
                   std::uint64_t first_tick)
    : engine_(std::move(engine)), recorder_(recorder), records_(engine_.hand_count()) {
  for (std::size_t h = 0; h < engine_.hand_count(); ++h)
    cores_.emplace_back(force, 1 / rate_hz, h, first_tick);
  if (recorder_) recorder_->begin(engine_, force, rate_hz, first_tick, true);
  last_outcome_.next_commands = engine_.take_initial_commands();
  issue_next(last_outcome_);
}

haptics::ServoRecord Lockstep::step(const haptics::Pose& pose) { return step(std::span(&pose, 1))[0]; }

std::span<const haptics::ServoRecord> Lockstep::step(std::span<const haptics::Pose> poses) {
  TREPHINE_ASSERT(poses.size() == cores_.size());
  {
    const haptics::DenormalsFlushed flushed;
    haptics::HandPlacements hand_placements;
    if (engine_.servo_scene()->has_held)
      hand_placements = haptics::placements_before(cores_, cores_[0].next_tick());
    for (std::size_t h = 0; h < cores_.size(); ++h) {
      haptics::ServoInput input;
      input.hand_placements = &hand_placements;
      input.pose = haptics::rounded_to_grid(poses[h]);
      input.is_reset = is_reset_;
      records_[h] = cores_[h].step(*engine_.servo_scene(), input);
    }
  }
  is_reset_ = false;
  last_outcome_ = {};
  for (const haptics::ServoRecord& record : records_) {
    const Outcome outcome = engine_.apply(record);
    if (recorder_) recorder_->add(record, engine_, outcome);
    add(last_outcome_, outcome);
    last_outcome_.next_commands.insert(last_outcome_.next_commands.end(), outcome.next_commands.begin(),
                                       outcome.next_commands.end());
  }
  issue_next(last_outcome_);
  if (pieces_) {
    const PieceWatch::Detection found = pieces_->after_tick(engine_);
    if (found == PieceWatch::Detection::disconnected ||
        (found == PieceWatch::Detection::pending && !pieces_->search(engine_).make(0).is_empty)) {
      add(last_outcome_, apply_and_finish(pieces_->command()));
    }
  }
  // Offset fields follow some ticks after the cuts, as in live operation.
  stale_ticks_ = engine_.has_stale_fields() ? stale_ticks_ + 1 : 0;
  if (stale_ticks_ == k_offsets_every) {
    for (std::size_t h = 0; h < engine_.hand_count(); ++h)
      if (const auto adoption = engine_.finish_derived_job(DerivedKind::offset_fields)) apply(*adoption);
    stale_ticks_ = 0;
  }
  // Depth images are adopted at once.
  while (const auto adoption = engine_.finish_derived_job(DerivedKind::depth_images))
    last_outcome_.is_changed |= apply(*adoption).is_changed;
  return records_;
}

Outcome Lockstep::apply_and_finish(const Command& command) {
  Outcome outcome = apply(command);
  Outcome done = finish_job_of(outcome);
  issue_next(done);
  add(outcome, done);
  if (done.job_hash) outcome.job_hash = done.job_hash;
  outcome.failed = std::move(done.failed);
  return outcome;
}

Outcome Lockstep::apply(const Command& command) {
  Outcome outcome = apply_alone(command);
  issue_next(outcome);
  return outcome;
}

/// Applies the commands that steps issue, and finishes their jobs.
void Lockstep::issue_next(Outcome& outcome) {
  issue(std::exchange(outcome.next_commands, {}), [&](const Command& command) {
    Outcome issued = apply_alone(command);
    Outcome done = finish_job_of(issued);
    add(outcome, issued);
    add(outcome, done);
    issued.next_commands.insert(issued.next_commands.end(), done.next_commands.begin(),
                                done.next_commands.end());
    return std::move(issued.next_commands);
  });
}

/// Finishes the job that a command has begun and that is still pending.
Outcome Lockstep::finish_job_of(const Outcome& outcome) {
  const auto& pending = engine_.jobs();
  if (outcome.refused || outcome.job.value == 0 ||
      std::none_of(pending.begin(), pending.end(),
                   [&](const PendingJob& job) { return job.id == outcome.job; }))
    return {};
  return apply_alone(engine_.run_job(outcome.job));
}

Outcome Lockstep::apply_alone(const Command& command) {
  Outcome outcome = engine_.apply(command);
  if (recorder_) recorder_->add(command, engine_, outcome);
  if (pieces_) pieces_->after_command(engine_, command, outcome);
  return outcome;
}

}  // namespace trephine::sim
