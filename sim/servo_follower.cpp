#include "sim/servo_follower.h"

namespace trephine::sim {

ServoFollower::ServoFollower(const haptics::ForceOptions& options, double dt, std::size_t hands,
                             std::shared_ptr<const haptics::ServoScene> first, std::uint64_t first_tick)
    : options_(options), dt_(dt) {
  for (std::size_t h = 0; h < hands; ++h) cores_.emplace_back(options_, dt_, h, first_tick);
  seen_.push_back(std::move(first));
}

bool ServoFollower::can_follow(const haptics::ServoRecord& recorded) const noexcept {
  return recorded.hand < cores_.size() && recorded.tick >= cores_[recorded.hand].next_tick();
}

haptics::ServoRecord ServoFollower::step(const haptics::ServoRecord& recorded) {
  haptics::ServoCore& core = cores_[recorded.hand];
  const haptics::DenormalsFlushed flushed;
  gap_ = recorded.tick - core.next_tick();
  // Ticks that found no room in the ring: nothing was touched, and the force went on fading.
  if (gap_ > 0) core.skip(recorded.raised | haptics::fault_full_ring, gap_);
  see(recorded.version);
  haptics::ServoInput input;
  haptics::HandPlaces places;
  if (seen_.front()->has_held) places = haptics::places_before(cores_, recorded.tick);
  input.places = &places;
  input.pose = recorded.pose;
  input.faults = recorded.raised;
  input.is_reset = recorded.is_reset;
  input.is_restarted = recorded.is_restarted;
  input.restart_volume = recorded.restart_volume;
  return core.step(*seen_.front(), input);
}

void ServoFollower::see(std::uint64_t serial) {
  while (seen_.size() > 1 && seen_.front()->serial < serial && seen_[1]->serial <= serial) seen_.pop_front();
}

void ServoFollower::begin_anew(std::uint64_t first_tick) {
  for (std::size_t h = 0; h < cores_.size(); ++h)
    cores_[h] = haptics::ServoCore(options_, dt_, h, first_tick);
}

}  // namespace trephine::sim
