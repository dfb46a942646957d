// Recorded or planned motion of a stylus: the one path format,
// `t,x,y,z[,qx,qy,qz,qw][,button or buttons][,axis1,axis2,axis3,axis4]`.
#pragma once

#include <array>
#include <cstdint>
#include <glm/gtc/quaternion.hpp>
#include <glm/vec3.hpp>
#include <iosfwd>
#include <string>
#include <vector>

#include "volume/error.h"

namespace trephine::haptics {

/// Pose of a stylus in the world frame (mm), and its switches.
struct Pose {
  glm::dvec3 position_world{0.0};
  glm::dquat orientation{1, 0, 0, 0};  ///< w, x, y, z
  std::uint32_t buttons = 1;           ///< one bit each; the first is the one that works the tool
  std::array<float, 4> axes{};  ///< of squeeze, pedals and wheels, as the device counts: 0 to 1, or -1 to 1

  static constexpr float k_farthest_axis = 1e6f;

  bool is_pressed() const noexcept { return buttons & 1u; }
  void press(bool is_pressed) noexcept { buttons = (buttons & ~1u) | (is_pressed ? 1u : 0u); }
};

/// The pose as a servo takes it: places on a grid of 2^-20 mm (1 nm), quaternions on one of 2^-24, finer than
/// what any device says, so that a recording holds inputs exactly in few bytes. What is no number stays so.
Pose on_grid(Pose pose) noexcept;
/// Unit quaternion; identity where the device reports no valid rotation.
glm::dquat unit_of(const glm::dquat& orientation) noexcept;
/// Rotation of `to` from `from`, radians about the axis, for small rotations; of
/// large ones twice the sine of their half.
glm::dvec3 turn_between(const glm::dquat& from, const glm::dquat& to) noexcept;
inline constexpr double k_place_grid = 0x1p-20, k_turn_grid = 0x1p-24;

/// Poses at strictly rising times (s). Sampled linearly in between; before and after, the ends hold.
class PosePath {
 public:
  struct Sample {
    double t;
    Pose pose;
  };
  /// Error when there is no sample, a value is not finite, or a time does not rise; `where` names the source.
  static volume::Result<PosePath> from_samples(std::vector<Sample> samples, const std::string& where);
  /// Reads CSV with a header line naming the columns: `button` is 0 or 1, `buttons` a number whose bits are
  /// all of them. A path without either is pressed throughout.
  static volume::Result<PosePath> read_csv(std::istream& in, const std::string& where);

  /// Not for unsorted access in hot loops: binary search.
  Pose at(double t) const noexcept;
  double start_time() const noexcept { return samples_.front().t; }
  double end_time() const noexcept { return samples_.back().t; }
  const std::vector<Sample>& samples() const noexcept { return samples_; }
  void write_csv(std::ostream& out) const;

 private:
  std::vector<Sample> samples_;
};

/// Times at which a servo of `rate_hz` looks at a path: from its first to its last moment, the last one
/// included.
std::vector<double> servo_times(const PosePath& path, double rate_hz);

}  // namespace trephine::haptics
