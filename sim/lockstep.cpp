#include "sim/lockstep.h"

namespace trephine::sim {

Lockstep::Lockstep(const haptics::TouchScene& scene, const haptics::ProxyMethod& method, Tool* tool,
                   const haptics::ForceOptions& force, double rate_hz, SessionWriter* recorder)
    : Lockstep(EditSession(scene, method, tool, 1 / rate_hz), force, rate_hz, recorder, 0) {}

Lockstep::Lockstep(EditSession edits, const haptics::ForceOptions& force, double rate_hz,
                   SessionWriter* recorder, std::uint64_t first_tick)
    : edits_(std::move(edits)), servo_(force, 1 / rate_hz, 0, first_tick), recorder_(recorder) {}

haptics::ServoRecord Lockstep::step(const haptics::Pose& pose) {
  haptics::ServoInput input;
  input.pose = pose;
  haptics::ServoRecord record;
  {
    const haptics::DenormalsFlushed flushed;
    record = servo_.step(*edits_.servo_scene(), input);
  }
  last_edit_ = edits_.consume(record);
  if (recorder_) recorder_->add(record, edits_, last_edit_);
  // A round tool's fields follow a while after the cuts, as they do live.
  ticks_owed_ = edits_.has_stale_offsets() ? ticks_owed_ + 1 : 0;
  if (ticks_owed_ == k_offsets_every) {
    apply({Command::Kind::offsets, 0, {}, static_cast<double>(edits_.current()->serial())});
    ticks_owed_ = 0;
  }
  return last_record_ = record;
}

EditOutcome Lockstep::apply(const Command& command) {
  const EditOutcome outcome = edits_.apply(command);
  if (recorder_) recorder_->add(command, edits_, outcome);
  return outcome;
}

}  // namespace trephine::sim
