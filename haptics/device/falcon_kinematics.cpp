#include "haptics/device/falcon_kinematics.h"

#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

namespace trephine::haptics {

using glm::dmat3;
using glm::dvec3;

namespace {

constexpr double k_pi = 3.14159265358979323846;

// Lengths of the mechanism, mm, with the letters of Stamper (1997), as published by libnifalcon.
constexpr double k_a = 60;                         // upper arm
constexpr double k_b = 102.5;                      // long side of the parallelogram
constexpr double k_c = 14.43;                      // grip to its joint, along u
constexpr double k_d_plus_e = 22.5;                // sum of the two short sides
constexpr double k_f = -25;                        // grip to its joint, along v
constexpr double k_r = 40;                         // centre of the base to the shoulder, along u
constexpr double k_s = -23.09;                     // centre of the base to the shoulder, along v
constexpr double k_shoulders[] = {90, -30, -150};  // degrees, plus k_turn
constexpr double k_turn = 15;

constexpr double k_counts_per_turn = 4 * 320;        // of the motor's encoder
constexpr double k_reduction = 14.25 / 110;          // diameters of the motor's shaft and of the arm's drum
constexpr double k_angle_at_zero = 35 * k_pi / 180;  // rad, after homing

/// Axes of an arm in the device frame: u from the centre to the shoulder, v across. w is z.
struct ArmAxes {
  dvec3 u, v;
};
const std::array<ArmAxes, 3>& arms() noexcept {
  static const std::array<ArmAxes, 3> axes = [] {
    std::array<ArmAxes, 3> result;
    for (std::size_t i = 0; i < 3; ++i) {
      const double angle = (k_shoulders[i] + k_turn) * k_pi / 180;
      result[i] = {{std::cos(angle), std::sin(angle), 0}, {-std::sin(angle), std::cos(angle), 0}};
    }
    return result;
  }();
  return axes;
}

/// Position of the grip's joint from the shoulder, in the axes of an arm: along u, across (v) and out (w).
struct Joint {
  double along, across, out;
};
Joint joint_of(const ArmAxes& arm, const dvec3& p) noexcept {
  return {glm::dot(arm.u, p) - k_r + k_c, glm::dot(arm.v, p) - k_s + k_f, p.z};
}

/// Error of the length of an arm's parallelogram, mm, with its derivatives.
struct Closure {
  double value;
  dvec3 by_position;
  double by_angle;
};
std::optional<Closure> closure(const ArmAxes& arm, double angle, const dvec3& p) noexcept {
  const Joint joint = joint_of(arm, p);
  const double c = std::cos(angle), s = std::sin(angle);
  const double du = joint.along - k_a * c, dw = joint.out - k_a * s;
  const double distance = std::sqrt(du * du + dw * dw), in_plane = distance - k_d_plus_e;
  const double length = std::sqrt(in_plane * in_plane + joint.across * joint.across);
  if (!(distance > 1) || !(length > 1)) return std::nullopt;
  const double by_distance = in_plane / length;
  const double by_u = by_distance * du / distance, by_w = by_distance * dw / distance;
  return Closure{length - k_b, by_u * arm.u + joint.across / length * arm.v + by_w * dvec3(0, 0, 1),
                 by_u * k_a * s - by_w * k_a * c};
}

}  // namespace

double FalconKinematics::angle_of(std::int16_t count) noexcept {
  return k_angle_at_zero + count * (2 * k_pi / k_counts_per_turn * k_reduction);
}

std::optional<FalconAngles> FalconKinematics::inverse(const dvec3& p) noexcept {
  FalconAngles angles{};
  for (std::size_t i = 0; i < 3; ++i) {
    const Joint joint = joint_of(arms()[i], p);
    const double in_plane_square = k_b * k_b - joint.across * joint.across;
    if (!(in_plane_square >= 0)) return std::nullopt;
    // The elbow lies on two circles: about the shoulder, and about the joint of the grip.
    const double reach = std::sqrt(in_plane_square) + k_d_plus_e;
    const double square = joint.along * joint.along + joint.out * joint.out;
    const double cosine = (square + k_a * k_a - reach * reach) / (2 * k_a * std::sqrt(square));
    if (!(std::abs(cosine) <= 1)) return std::nullopt;
    angles[i] = std::atan2(joint.out, joint.along) - std::acos(cosine);
  }
  return angles;
}

std::optional<dvec3> FalconKinematics::forward(const FalconAngles& angles, const dvec3& guess) noexcept {
  constexpr int k_steps = 20;
  constexpr double k_exact = 1e-9, k_longest = 40, k_farthest = 90;  // mm
  dvec3 p = guess;
  for (int step = 0; step < k_steps; ++step) {
    dmat3 gradients;  // one per column
    dvec3 error;
    for (std::size_t i = 0; i < 3; ++i) {
      const auto arm = closure(arms()[i], angles[i], p);
      if (!arm) return std::nullopt;
      gradients[static_cast<int>(i)] = arm->by_position;
      error[static_cast<int>(i)] = arm->value;
    }
    if (!(std::abs(glm::determinant(gradients)) > 1e-6)) return std::nullopt;
    dvec3 move = error * glm::inverse(gradients);
    const double length = glm::length(move);
    if (length > k_longest) move *= k_longest / length;
    p -= move;
    if (length < k_exact) return glm::length(p - k_centre) < k_farthest ? std::optional(p) : std::nullopt;
  }
  return std::nullopt;
}

std::optional<dmat3> FalconKinematics::jacobian(const FalconAngles& angles, const dvec3& p) noexcept {
  dmat3 columns;
  for (std::size_t i = 0; i < 3; ++i) {
    const auto arm = closure(arms()[i], angles[i], p);
    if (!arm || !(std::abs(arm->by_angle) > 1e-3)) return std::nullopt;
    columns[static_cast<int>(i)] = -arm->by_position / arm->by_angle;
  }
  return glm::transpose(columns);
}

std::optional<std::array<double, 3>> FalconKinematics::torques(const FalconAngles& angles, const dvec3& p,
                                                               const dvec3& force) noexcept {
  const auto j = jacobian(angles, p);
  if (!j || !(std::abs(glm::determinant(*j)) > 1e-9)) return std::nullopt;
  // force . v = torque . (J v) for each v, so force = J^T torque.
  const dvec3 torque = glm::inverse(glm::transpose(*j)) * force;
  return std::array<double, 3>{torque.x, torque.y, torque.z};
}

}  // namespace trephine::haptics
