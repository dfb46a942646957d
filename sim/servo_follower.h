// Servo cores that repeat recorded ticks: for replays, and for programs that keep what a servo
// remembers without asking it.
#pragma once

#include <deque>
#include <memory>
#include <span>
#include <vector>

#include "haptics/servo/servo_core.h"

namespace trephine::sim {

/// A value. Each tick sees the scene that it saw then.
class ServoFollower {
 public:
  ServoFollower(const haptics::ForceOptions& options, double dt, std::size_t hands,
                std::shared_ptr<const haptics::ServoScene> first, std::uint64_t first_tick = 0);

  /// A newer scene, which coming ticks may see.
  void publish(std::shared_ptr<const haptics::ServoScene> scene) { seen_.push_back(std::move(scene)); }
  /// Is it of a hand that there is, and not before that hand's last tick?
  bool can_follow(const haptics::ServoRecord& recorded) const noexcept;
  /// Steps the tick of these inputs; unrecorded ticks before it are made up for.
  haptics::ServoRecord step(const haptics::ServoRecord& recorded);
  /// A tick that is not followed saw this.
  void see(std::uint64_t serial);
  /// The devices begin again.
  void begin_anew(std::uint64_t first_tick);
  /// Goes on with cores that were saved.
  void set_cores(std::vector<haptics::ServoCore> cores) { cores_ = std::move(cores); }

  /// Scenes of the last tick, and of a coming one.
  const std::shared_ptr<const haptics::ServoScene>& seen() const noexcept { return seen_.front(); }
  /// Last published scene.
  const std::shared_ptr<const haptics::ServoScene>& newest() const noexcept { return seen_.back(); }
  const std::vector<haptics::ServoCore>& cores() const noexcept { return cores_; }
  /// Number of unrecorded ticks before the last one.
  std::uint64_t gap() const noexcept { return gap_; }

 private:
  haptics::ForceOptions options_;
  double dt_;
  std::vector<haptics::ServoCore> cores_;
  std::deque<std::shared_ptr<const haptics::ServoScene>> seen_;
  std::uint64_t gap_ = 0;
};

}  // namespace trephine::sim
