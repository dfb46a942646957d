// PosePath: recorded or planned motion of a stylus, in the project's only path format
// `t,x,y,z[,qx,qy,qz,qw][,button or buttons][,axis1,axis2,axis3,axis4]`.
#pragma once

#include <array>
#include <cstdint>
#include <glm/gtc/quaternion.hpp>
#include <glm/vec3.hpp>
#include <iosfwd>
#include <string>
#include <vector>

#include "volume/base/error.h"

namespace trephine::haptics {

/// Pose of a stylus in the world frame (mm), with its buttons and axes.
struct Pose {
  glm::dvec3 position_world{0.0};
  glm::dquat orientation{1, 0, 0, 0};  ///< w, x, y, z
  std::uint32_t buttons = 1;           ///< one bit per button; the first one activates the tool
  std::array<float, 4> axes{};  ///< squeeze, pedals and wheels, in the device's range: 0 to 1, or -1 to 1

  static constexpr float k_farthest_axis = 1e6f;  ///< largest absolute value of an axis

  bool is_pressed() const noexcept { return buttons & 1u; }
  void press(bool is_pressed) noexcept { buttons = (buttons & ~1u) | (is_pressed ? 1u : 0u); }
};

/// Rounds a pose to the grids of the servo: positions to 2^-20 mm (1 nm), quaternions to 2^-24. Both are
/// finer than any device reports, and a recording stores the rounded values exactly in few bytes. Values that
/// are not finite stay so.
Pose rounded_to_grid(Pose pose) noexcept;
/// Returns the quaternion divided by its length; identity if the length is not finite or close to 0.
glm::dquat unit_of(const glm::dquat& orientation) noexcept;
/// Returns the rotation from `from` to `to` as axis times 2 sin(angle / 2), which is close to the angle in
/// radians for small rotations.
glm::dvec3 turn_between(const glm::dquat& from, const glm::dquat& to) noexcept;
inline constexpr double k_position_grid = 0x1p-20, k_rotation_grid = 0x1p-24;

/// Poses at strictly increasing times (s), interpolated linearly; constant before the first and after the
/// last.
class PosePath {
 public:
  struct Sample {
    double t;
    Pose pose;
  };
  /// Error if there is no sample, a value is not finite or out of range, an orientation is not a unit
  /// quaternion, or a time does not increase. `where`: name of the source, for the error.
  static Result<PosePath> from_samples(std::vector<Sample> samples, const std::string& where);
  /// Reads CSV with a header line that names the columns: `button` is 0 or 1, `buttons` a number with one bit
  /// per button. In a path without either column, the first button is always pressed.
  static Result<PosePath> read_csv(std::istream& in, const std::string& where);

  /// Returns the pose at time t (s) by binary search: too slow for unsorted access in hot loops.
  Pose at(double t) const noexcept;
  double start_time() const noexcept { return samples_.front().t; }
  double end_time() const noexcept { return samples_.back().t; }
  const std::vector<Sample>& samples() const noexcept { return samples_; }
  void write_csv(std::ostream& out) const;

 private:
  std::vector<Sample> samples_;
};

/// Returns the times (s) at which a servo of `rate_hz` samples a path, from its first to its last time, both
/// included.
std::vector<double> servo_times(const PosePath& path, double rate_hz);

}  // namespace trephine::haptics
