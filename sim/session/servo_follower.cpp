#include "sim/session/servo_follower.h"

namespace trephine::sim {

ServoFollower::ServoFollower(const haptics::ForceOptions& options, double dt, std::size_t hands,
                             std::shared_ptr<const haptics::ServoScene> first, std::uint64_t first_tick)
    : options_(options), dt_(dt) {
  for (std::size_t h = 0; h < hands; ++h) cores_.emplace_back(options_, dt_, h, first_tick);
  scenes_.push_back(std::move(first));
}

bool ServoFollower::can_follow(const haptics::ServoRecord& recorded) const noexcept {
  return recorded.hand < cores_.size() && recorded.tick >= cores_[recorded.hand].next_tick();
}

haptics::ServoRecord ServoFollower::step(const haptics::ServoRecord& recorded) {
  haptics::ServoCore& core = cores_[recorded.hand];
  const haptics::DenormalsFlushed flushed;
  gap_ = recorded.tick - core.next_tick();
  // Ticks are missing if the ring buffer of the recording was full. In these ticks the servo kept the proxy
  // and faded the force.
  if (gap_ > 0) core.skip(recorded.raised | haptics::fault_full_ring, gap_);
  advance_to(recorded.version);
  haptics::HandPlacements hand_placements;
  return core.step(*scenes_.front(), input_of(recorded, hand_placements));
}

/// Returns the input of a recorded tick. The input refers to `hand_placements`, which must outlive it.
haptics::ServoInput ServoFollower::input_of(const haptics::ServoRecord& recorded,
                                            haptics::HandPlacements& hand_placements) const {
  if (scenes_.front()->has_held) hand_placements = haptics::placements_before(cores_, recorded.tick);
  haptics::ServoInput input;
  input.hand_placements = &hand_placements;
  input.pose = recorded.pose;
  input.faults = recorded.raised;
  input.is_reset = recorded.is_reset;
  input.is_restarted = recorded.is_restarted;
  input.restart_volume = recorded.restart_volume;
  return input;
}

haptics::ForceParts ServoFollower::force_parts(const haptics::ServoRecord& recorded) const {
  ServoFollower copy = *this;
  haptics::ServoCore& core = copy.cores_[recorded.hand];
  const haptics::DenormalsFlushed flushed;
  const std::uint64_t gap = recorded.tick - core.next_tick();
  if (gap > 0) core.skip(recorded.raised | haptics::fault_full_ring, gap);
  copy.advance_to(recorded.version);
  haptics::HandPlacements hand_placements;
  return haptics::force_parts(core, *copy.scenes_.front(), copy.input_of(recorded, hand_placements));
}

void ServoFollower::advance_to(std::uint64_t serial) {
  while (scenes_.size() > 1 && scenes_.front()->serial < serial && scenes_[1]->serial <= serial)
    scenes_.pop_front();
}

void ServoFollower::restart(std::uint64_t first_tick) {
  for (std::size_t h = 0; h < cores_.size(); ++h)
    cores_[h] = haptics::ServoCore(options_, dt_, h, first_tick);
}

}  // namespace trephine::sim
