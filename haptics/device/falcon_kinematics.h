// FalconKinematics: geometry of the Novint Falcon's three arms.
#pragma once

#include <array>
#include <cstdint>
#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>
#include <optional>

namespace trephine::haptics {

/// Pose of the arms: angles from the base plane, rad.
using FalconAngles = std::array<double, 3>;

/// Delta mechanism with three parallelogram arms (Stamper 1997, dissertation, University of Maryland). Device
/// frame: x to the right, y up, z from the base toward the user; the origin is in the base plane. mm and rad.
class FalconKinematics {
 public:
  /// Centre of the workspace.
  static constexpr glm::dvec3 k_centre{0, 0, 125};
  static constexpr double k_workspace_radius = 50;  ///< mm
  /// Angle of an arm per count of its encoder, rad.
  static double angle_of(std::int16_t count) noexcept;

  /// Returns the angles of the arms that hold the grip at a position; nothing if an arm cannot reach it.
  static std::optional<FalconAngles> inverse(const glm::dvec3& position) noexcept;
  /// Returns the position of the grip to 1e-9 mm by Newton's method from `guess`, at most 20 steps; nothing
  /// if the angles fit no position within 90 mm of the centre.
  static std::optional<glm::dvec3> forward(const FalconAngles& angles,
                                           const glm::dvec3& guess = k_centre) noexcept;
  /// Returns d(angles)/d(position), rad/mm, a row for each arm; nothing at a singular position.
  static std::optional<glm::dmat3> jacobian(const FalconAngles& angles, const glm::dvec3& position) noexcept;
  /// Returns the torques of the arms (N mm) that render a force (N) at a position: the power of both is
  /// equal for each motion. Nothing at a singular position.
  static std::optional<std::array<double, 3>> torques(const FalconAngles& angles, const glm::dvec3& position,
                                                      const glm::dvec3& force) noexcept;
};

}  // namespace trephine::haptics
