#include "sim/session/checkpoint.h"

#include <algorithm>

#include "haptics/servo/servo_memory.h"
#include "sim/session/session_format.h"
#include "volume/fields/offset_changes.h"

namespace trephine::sim {

namespace {
// Costs of the items of a replay. The unit is the cost of a tick without contact. A tick with contact costs
// more: 15 us if the hand slides at a large depth.
constexpr int k_cost_of_touch = 2, k_cost_of_cut = 10, k_cost_of_fields = 1000, k_cost_of_brick = 300,
              k_cost_of_history = 300, k_cost_of_job = 8000;
/// Cost of building the fields `after` from `before`.
int work_of(const OffsetFields& before, const OffsetFields& after) {
  std::size_t bricks = 0;
  for (std::size_t s = 0; s < after.size() && s < before.size(); ++s)
    bricks += volume::OffsetChanges::count(*before[s], *after[s]);
  return k_cost_of_fields + k_cost_of_brick * static_cast<int>(std::min<std::size_t>(bricks, 1000));
}
}  // namespace

CheckpointMaker::CheckpointMaker(const Engine& engine, const haptics::ForceOptions& force, double dt,
                                 std::uint64_t first_tick, int work)
    : servo_(force, dt, engine.hand_count(), engine.servo_scene(), first_tick),
      work_between_(work),
      has_adopted_(engine.hand_count()) {}

void CheckpointMaker::add(const haptics::ServoRecord& record, const Engine& engine, const Outcome& outcome) {
  if (!is_faithful_) return;
  is_faithful_ = servo_.can_follow(record) && output_check(servo_.step(record)) == output_check(record);
  if (outcome.is_changed) servo_.publish(engine.servo_scene());
  count(outcome.is_changed ? k_cost_of_cut : record.has_contact ? k_cost_of_touch : 1);
  if (!is_faithful_) pending_.reset();
  if (!pending_) return;
  if (!is_servo_done_) {
    pending_->records.push_back(record);
    has_adopted_[record.hand] = record.version >= pending_->snapshot.serial;
    if (std::find(has_adopted_.begin(), has_adopted_.end(), false) == has_adopted_.end())
      finish_servo();
    else if (pending_->records.size() >= k_max_records)
      return pending_.reset();
  }
  are_fields_done_ = engine.oldest_stale_serial() > pending_->snapshot.serial;
}

void CheckpointMaker::add(const Command& command, const Engine& engine, const Outcome& outcome) {
  if ((outcome.refused && !outcome.is_refusal_recorded) || !is_faithful_) return;
  if (command.request.as<Resume>()) {
    servo_.restart(engine.state().next_tick);
    pending_.reset();
  }
  const auto* adopt = command.request.as<Adopt>();
  if (adopt && adopt->kind != DerivedKind::offset_fields) adopt = nullptr;
  const auto offsets_of = [&](const haptics::ServoScene& scene) -> const OffsetFields& {
    return scene.hands[command.hand].state.offsets;
  };
  count(adopt ? work_of(offsets_of(*servo_.newest()), offsets_of(*engine.servo_scene()))
        : command.request.as<AdoptJob>() ? k_cost_of_job
        : outcome.is_changed             ? k_cost_of_history
                                         : 1);
  if (outcome.is_changed) servo_.publish(engine.servo_scene());
  if (pending_ && adopt && outcome.is_changed &&
      static_cast<std::uint64_t>(adopt->serial) <= pending_->snapshot.serial)
    pending_->fields.push_back(
        {static_cast<std::uint64_t>(adopt->serial), command.hand, offsets_of(*engine.servo_scene())});
}

void CheckpointMaker::begin(Engine& engine, std::uint64_t block) {
  work_ = 0;
  pending_ = std::make_unique<Checkpoint>();
  pending_->block = block;
  pending_->snapshot = engine.full_snapshot();
  std::fill(has_adopted_.begin(), has_adopted_.end(), false);
  is_servo_done_ = are_fields_done_ = false;
}

/// Adds work, at most up to the amount at which a checkpoint is due. The sum thus stays bounded while no
/// checkpoint can be made.
void CheckpointMaker::count(int work) noexcept { work_ = std::min(work_ + work, work_between_); }

void CheckpointMaker::finish_servo() {
  is_servo_done_ = true;
  for (std::size_t h = 0; h < servo_.cores().size(); ++h) {
    const haptics::ServoCore& core = servo_.cores()[h];
    pending_->cores.push_back(haptics::ServoMemory::save(core, servo_.current_scene()->hands[h]));
    pending_->next_tick = std::max(pending_->next_tick, core.next_tick());
  }
}

std::unique_ptr<Checkpoint> CheckpointMaker::fetch_checkpoint() {
  return pending_ && is_servo_done_ && are_fields_done_ ? std::move(pending_) : nullptr;
}

}  // namespace trephine::sim
