// ServoFollower: servo cores that repeat recorded ticks, for replays and for checkpoints, which store the
// memory of a running servo.
#pragma once

#include <deque>
#include <memory>
#include <span>
#include <vector>

#include "haptics/servo/force_parts.h"
#include "haptics/servo/servo_core.h"

namespace trephine::sim {

/// A value. Each tick uses the scene that the recorded tick used.
class ServoFollower {
 public:
  ServoFollower(const haptics::ForceOptions& options, double dt, std::size_t hands,
                std::shared_ptr<const haptics::ServoScene> first, std::uint64_t first_tick = 0);

  /// Adds a newer scene, which following ticks may use.
  void publish(std::shared_ptr<const haptics::ServoScene> scene) { scenes_.push_back(std::move(scene)); }
  /// True if the tick belongs to an existing hand, and is later than the last tick of that hand.
  bool can_follow(const haptics::ServoRecord& recorded) const noexcept;
  /// Repeats a tick from its recorded inputs, after the unrecorded ticks before it.
  haptics::ServoRecord step(const haptics::ServoRecord& recorded);
  /// Returns the parts of the force that step() would give.
  haptics::ForceParts force_parts(const haptics::ServoRecord& recorded) const;
  /// Advances to the scene that a skipped tick used.
  void advance_to(std::uint64_t serial);
  /// Resets all cores: the devices start again.
  void restart(std::uint64_t first_tick);
  /// Replaces the cores by saved ones.
  void set_cores(std::vector<haptics::ServoCore> cores) { cores_ = std::move(cores); }

  /// Scene of the last tick.
  const std::shared_ptr<const haptics::ServoScene>& current_scene() const noexcept { return scenes_.front(); }
  /// Last published scene.
  const std::shared_ptr<const haptics::ServoScene>& newest() const noexcept { return scenes_.back(); }
  const std::vector<haptics::ServoCore>& cores() const noexcept { return cores_; }
  /// Number of unrecorded ticks directly before the tick of the last step().
  std::uint64_t gap() const noexcept { return gap_; }

 private:
  haptics::ServoInput input_of(const haptics::ServoRecord& recorded,
                               haptics::HandPlacements& hand_placements) const;

  haptics::ForceOptions options_;
  double dt_;
  std::vector<haptics::ServoCore> cores_;
  std::deque<std::shared_ptr<const haptics::ServoScene>> scenes_;
  std::uint64_t gap_ = 0;
};

}  // namespace trephine::sim
