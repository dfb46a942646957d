// Servo cores that go through recorded ticks once more: for replays, and for whoever keeps what a servo
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
  /// The tick of these inputs; ticks before it that nobody was told of are made up for.
  haptics::ServoRecord step(const haptics::ServoRecord& recorded);
  /// A tick that is not followed saw this.
  void see(std::uint64_t serial);
  /// The devices begin anew.
  void begin_anew(std::uint64_t first_tick);
  /// Goes on with cores that were saved.
  void set_cores(std::vector<haptics::ServoCore> cores) { cores_ = std::move(cores); }

  /// What the last tick saw, and a coming one may see.
  const std::shared_ptr<const haptics::ServoScene>& seen() const noexcept { return seen_.front(); }
  /// What was published last.
  const std::shared_ptr<const haptics::ServoScene>& newest() const noexcept { return seen_.back(); }
  const std::vector<haptics::ServoCore>& cores() const noexcept { return cores_; }
  /// Ticks before the last one that nobody was told of.
  std::uint64_t gap() const noexcept { return gap_; }

 private:
  haptics::ForceOptions options_;
  double dt_;
  std::vector<haptics::ServoCore> cores_;
  std::deque<std::shared_ptr<const haptics::ServoScene>> seen_;
  std::uint64_t gap_ = 0;
};

}  // namespace trephine::sim
