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
  // Unrecorded ticks found the ring full: the proxy stayed, and the force faded further.
  if (gap_ > 0) core.skip(recorded.raised | haptics::fault_full_ring, gap_);
  see(recorded.version);
  haptics::ServoInput input;
  haptics::HandPlacements places;
  if (scenes_.front()->has_held) places = haptics::placements_before(cores_, recorded.tick);
  input.places = &places;
  input.pose = recorded.pose;
  input.faults = recorded.raised;
  input.is_reset = recorded.is_reset;
  input.is_restarted = recorded.is_restarted;
  input.restart_volume = recorded.restart_volume;
  return core.step(*scenes_.front(), input);
}

void ServoFollower::see(std::uint64_t serial) {
  while (scenes_.size() > 1 && scenes_.front()->serial < serial && scenes_[1]->serial <= serial)
    scenes_.pop_front();
}

void ServoFollower::restart(std::uint64_t first_tick) {
  for (std::size_t h = 0; h < cores_.size(); ++h)
    cores_[h] = haptics::ServoCore(options_, dt_, h, first_tick);
}

}  // namespace trephine::sim
