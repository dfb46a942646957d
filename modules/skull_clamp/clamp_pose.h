// ClampPose: a skull clamp of three pins in space: one pin on one side of the head, and opposite to it two on
// a rocker that swings.
#pragma once

#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <string_view>

#include "volume/base/error.h"
#include "volume/base/located_error.h"

namespace trephine::skull_clamp {

inline constexpr std::size_t k_pins = 3;  ///< the first is the single pin
using Pins = std::array<glm::dvec3, k_pins>;

/// Mechanical limits of a clamp.
struct ClampLimits {
  double least_opening = 100, most_opening = 240;  ///< mm, between the single tip and the rocker's middle
  double rocker_width = 90;                        ///< mm, between the tips of the pair
  double swing = 25;                               ///< degrees, to either side
};

/// Models of clamps; all have three pins. docs/skull-clamp.md lists their sizes, which are assumed.
enum class ClampModel : std::uint8_t { standard, small };
inline constexpr std::string_view k_clamp_models[] = {"standard", "small"};
struct ClampSize {
  ClampLimits limits;
  double arm_depth = 130;  ///< mm, of the arms' half ellipse around the head
};
/// Returns the sizes of a model.
ClampSize size_of(ClampModel model) noexcept;

/// Pose of a clamp. The axis leads from the single tip to the rocker's middle, between the tips of the pair.
struct ClampPose {
  glm::dvec3 origin_world{0.0};      ///< mm, single tip
  glm::dvec3 axis_world{1, 0, 0};    ///< unit
  glm::dvec3 across_world{0, 1, 0};  ///< unit, orthogonal to the axis: the rocker without swing, to pin 2
  double opening = 160;              ///< mm
  double swing = 0;                  ///< radians, of the rocker: positive turns pin 2 away from pin 1
  bool is_opening_limited = false;   ///< the opening is at a limit, which prevents a closer fit
  bool is_swing_limited = false;

  glm::dvec3 middle_world() const noexcept { return origin_world + opening * axis_world; }
  /// Returns the unit direction of the rocker, to pin 2.
  glm::dvec3 rocker_world() const noexcept;
  Pins tips_world(double rocker_width) const noexcept;
  /// Returns the unit directions of the pins, toward the head.
  Pins directions_world() const noexcept;
};

/// Returns the pose whose tips are nearest to three positions in the sense of least squares, within the
/// limits; or the reason why the positions hold no clamp. Deterministic.
Result<ClampPose, LocatedError> fit_pose(const Pins& pins_world, const ClampLimits& limits);

/// Returns the angle between two unit vectors, degrees.
double angle_between(const glm::dvec3& a, const glm::dvec3& b) noexcept;

}  // namespace trephine::skull_clamp
