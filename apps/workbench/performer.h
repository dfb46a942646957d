// Performer: moves the hands of a script as a person of a certain skill would. Places are displaced, and
// motions are slower, with pauses, overshoot and tremor. The same seed gives the same motion on every
// machine.
#pragma once

#include <span>
#include <string_view>
#include <vector>

#include "apps/workbench/places.h"
#include "haptics/device/pose_path.h"

namespace trephine::workbench {

/// Errors of a person's motion. Standard deviations are per axis. All values are assumed (docs/scores.md).
struct Skill {
  std::string_view name;
  double place_error = 0;  ///< mm, standard deviation along the surface; the height above it has no error
  double tilt = 0;         ///< radians, standard deviation of the direction of approach
  double tremor = 0;       ///< mm, RMS per axis at 8 to 12 Hz
  double drift = 0;        ///< mm, RMS per axis below 1 Hz
  double slowness = 1;     ///< duration, relative to the script
  double pauses_per_second = 0;  ///< mean number of pauses per second of the script
  double pause = 0;              ///< s, mean duration of a pause
  double bandwidth = 0;          ///< Hz, of the response to the planned motion; 0: exact
  double damping = 1;            ///< damping ratio of the response; below 1 it overshoots
};
/// Returns novice, trained and expert.
std::span<const Skill> skills() noexcept;
/// Returns null if there is no such skill.
const Skill* find_skill(std::string_view name) noexcept;

class Performer {
 public:
  /// `duration`: of the script, s.
  Performer(const Skill& skill, std::uint64_t seed, double duration);
  /// Displaces and tilts a place. Hands and commands that use the place are displaced with it.
  void displace(Place& place) const;
  /// Converts a time of the script to the time at which the performer reaches it, s. Monotonic.
  double time_of(double planned) const noexcept;
  /// Returns the motion of a hand with this index, from its motion in the script.
  haptics::PosePath perform(const haptics::PosePath& planned, std::size_t hand) const;

 private:
  /// Pause of `seconds` at the planned time `at`.
  struct Pause {
    double at, seconds;
  };
  /// Inverse of time_of().
  double planned_of(double time) const noexcept;

  Skill skill_;
  std::uint64_t seed_;
  double duration_;
  std::vector<Pause> pauses_;  ///< by time
};

}  // namespace trephine::workbench
