// Reports of 3Dconnexion SpaceMouse devices, and the tool that their deflection moves.
#pragma once

#include <array>
#include <cstdint>
#include <glm/gtc/quaternion.hpp>
#include <glm/vec3.hpp>
#include <span>

namespace trephine::haptics {

/// Deflection of the cap and its buttons. Device frame: x to the right, y up, z toward the user.
struct SpaceMouseState {
  std::array<std::int16_t, 3> motion{}, turn{};  ///< about -350 to 350
  std::uint32_t buttons = 0;
};

/// Reads input reports: 1 is motion, with the turn if the report is long enough, 2 is the turn, 3 the
/// buttons.
class SpaceMouseParser {
 public:
  /// Adds one report, with its number in the first byte. Returns false for other numbers, and for reports
  /// that are too short.
  bool add(std::span<const std::uint8_t> report) noexcept;
  /// Sets the deflection to zero: older devices send nothing at rest.
  void rest() noexcept { state_.motion = state_.turn = {}; }
  const SpaceMouseState& state() const noexcept { return state_; }

 private:
  SpaceMouseState state_;
};

struct RateControl {
  double speed = 60;        ///< mm/s at full deflection
  double turning = 1.2;     ///< rad/s at full deflection
  double radius = 200;      ///< mm; the tool stays within this ball about its start
  double dead_zone = 0.04;  ///< share of the full deflection that moves nothing
};

/// Pose that a deflection moves, since a device that springs back cannot hold a position. The speed is
/// proportional to the square of the deflection beyond the dead zone, for fine control of small motions.
class RatePose {
 public:
  explicit RatePose(const RateControl& control) : control_(control) {}
  /// Moves for `seconds`, of which at most 0.1 s count.
  void move(const SpaceMouseState& state, double seconds) noexcept;
  const glm::dvec3& position() const noexcept { return position_; }
  const glm::dquat& orientation() const noexcept { return orientation_; }

 private:
  RateControl control_;
  glm::dvec3 position_{0.0};
  glm::dquat orientation_{1, 0, 0, 0};
};

}  // namespace trephine::haptics
