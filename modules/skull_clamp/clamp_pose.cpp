#include "modules/skull_clamp/clamp_pose.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <string>

#include "volume/base/deterministic_math.h"

namespace trephine::skull_clamp {

using glm::dvec3;

namespace {

constexpr double k_radian = 57.295779513082320877;  // degrees
constexpr double k_least_distance = 20;             // mm, least distance between two pins
constexpr double k_in_line = 10;                    // mm, least height of the pins' triangle
constexpr double k_margin = 20;                     // mm, by which the axis may be below the least opening

// Unknowns: translation, rotation about the world's axes, opening, swing.
constexpr std::size_t k_unknowns = 8, k_opening = 6, k_swing = 7;
constexpr std::size_t k_equations = 3 * k_pins;
using Vector = std::array<double, k_unknowns>;

std::string rounded(double value) { return std::to_string(std::lround(value)); }

/// Checks that three positions span a clamp.
LocatedStatus check_pins(const Pins& pins, const ClampLimits& limits) {
  for (std::size_t i = 0; i < k_pins; ++i) {
    const std::size_t j = (i + 1) % k_pins;
    if (const double distance = glm::distance(pins[i], pins[j]); distance < k_least_distance)
      return LocatedError{"pins " + std::to_string(i + 1) + " and " + std::to_string(j + 1) + " are only " +
                              rounded(distance) + " mm apart: move one of them",
                          pins[i]};
  }
  double longest = 0;
  for (std::size_t i = 0; i < k_pins; ++i)
    longest = std::max(longest, glm::distance(pins[i], pins[(i + 1) % k_pins]));
  const double twice_area = glm::length(glm::cross(pins[1] - pins[0], pins[2] - pins[0]));
  if (twice_area < k_in_line * longest)
    return LocatedError{"the three pins are on one line: move one of them", pins[0]};
  const double axis = glm::distance(pins[0], 0.5 * (pins[1] + pins[2]));
  if (axis < limits.least_opening - k_margin)
    return LocatedError{"the pins are on the same side of the head: pin 1 is only " + rounded(axis) +
                            " mm from the middle of pins 2 and 3, and the clamp closes to " +
                            rounded(limits.least_opening) + " mm",
                        pins[0]};
  return std::nullopt;
}

/// Solves a symmetric positive definite system for the unknowns that are not held, by elimination. Held
/// unknowns are 0.
Vector solve(std::array<Vector, k_unknowns> matrix, Vector right, const std::array<bool, k_unknowns>& held) {
  for (std::size_t i = 0; i < k_unknowns; ++i) {
    if (!held[i]) continue;
    for (std::size_t j = 0; j < k_unknowns; ++j) matrix[i][j] = matrix[j][i] = 0;
    matrix[i][i] = 1, right[i] = 0;
  }
  for (std::size_t i = 0; i < k_unknowns; ++i)
    for (std::size_t j = i + 1; j < k_unknowns; ++j) {
      const double factor = matrix[j][i] / matrix[i][i];
      for (std::size_t k = i; k < k_unknowns; ++k) matrix[j][k] -= factor * matrix[i][k];
      right[j] -= factor * right[i];
    }
  Vector result{};
  for (std::size_t i = k_unknowns; i-- > 0;) {
    double sum = right[i];
    for (std::size_t k = i + 1; k < k_unknowns; ++k) sum -= matrix[i][k] * result[k];
    result[i] = sum / matrix[i][i];
  }
  return result;
}

dvec3 turned(const dvec3& v, const dvec3& axis, double angle) {
  const double c = deterministic_cos(angle), s = deterministic_sin(angle);
  return c * v + s * glm::cross(axis, v) + (1 - c) * glm::dot(axis, v) * axis;
}

class Fit {
 public:
  Fit(const Pins& pins, const ClampLimits& limits) : pins_(pins), limits_(limits) {}

  /// Starts with the axis through pin 1 and the middle of the pair, and improves the pose by Gauss-Newton
  /// steps. An unknown at a limit is held while the step leads beyond this limit.
  ClampPose run() {
    const dvec3 middle = 0.5 * (pins_[1] + pins_[2]);
    pose_.origin_world = pins_[0];
    pose_.axis_world = glm::normalize(middle - pins_[0]);
    const dvec3 rocker = glm::normalize(pins_[1] - pins_[2]);
    const double lean = glm::dot(rocker, pose_.axis_world);
    pose_.across_world = glm::normalize(rocker - lean * pose_.axis_world);
    pose_.opening = std::clamp(glm::distance(middle, pins_[0]), limits_.least_opening, limits_.most_opening);
    const double angle = 1.5707963267948966 - deterministic_acos(std::clamp(lean, -1.0, 1.0));
    pose_.swing = std::clamp(angle, -most_swing(), most_swing());
    constexpr int k_steps = 200;
    for (int i = 0; i < k_steps; ++i) improve();
    return pose_;
  }

 private:
  double most_swing() const noexcept { return limits_.swing / k_radian; }

  void improve() {
    const Pins tips = pose_.tips_world(limits_.rocker_width);
    const dvec3 turning = deterministic_cos(pose_.swing) * pose_.axis_world -
                          deterministic_sin(pose_.swing) * pose_.across_world;
    std::array<Vector, k_equations> slope{};
    std::array<double, k_equations> gap{};
    for (std::size_t pin = 0; pin < k_pins; ++pin) {
      std::array<dvec3, k_unknowns> columns{dvec3(1, 0, 0), dvec3(0, 1, 0), dvec3(0, 0, 1)};
      const dvec3 arm = tips[pin] - pose_.origin_world;
      for (std::size_t a = 0; a < 3; ++a) columns[3 + a] = glm::cross(columns[a], arm);
      if (pin > 0) {
        columns[k_opening] = pose_.axis_world;
        columns[k_swing] = (pin == 1 ? 0.5 : -0.5) * limits_.rocker_width * turning;
      }
      for (std::size_t a = 0; a < 3; ++a) {
        const auto c = static_cast<glm::length_t>(a);
        gap[3 * pin + a] = (pins_[pin] - tips[pin])[c];
        for (std::size_t u = 0; u < k_unknowns; ++u) slope[3 * pin + a][u] = columns[u][c];
      }
    }
    std::array<Vector, k_unknowns> matrix{};
    Vector right{};
    for (std::size_t e = 0; e < k_equations; ++e)
      for (std::size_t u = 0; u < k_unknowns; ++u) {
        right[u] += slope[e][u] * gap[e];
        for (std::size_t v = 0; v < k_unknowns; ++v) matrix[u][v] += slope[e][u] * slope[e][v];
      }
    for (std::size_t u = 0; u < k_unknowns; ++u) matrix[u][u] *= 1 + 1e-9;
    std::array<bool, k_unknowns> held{};
    Vector step = solve(matrix, right, held);
    for (int pass = 0; pass < 2; ++pass) {
      held[k_opening] = held[k_opening] || is_beyond(pose_.opening, step[k_opening], limits_.least_opening,
                                                     limits_.most_opening);
      held[k_swing] = held[k_swing] || is_beyond(pose_.swing, step[k_swing], -most_swing(), most_swing());
      step = solve(matrix, right, held);
    }
    pose_.is_opening_limited = held[k_opening], pose_.is_swing_limited = held[k_swing];
    move(step);
  }
  /// Returns true if an unknown is at a limit and the step leads beyond it.
  static bool is_beyond(double value, double step, double low, double high) {
    constexpr double k_least_step = 1e-9;
    return (value >= high && step > k_least_step) || (value <= low && step < -k_least_step);
  }
  void move(const Vector& step) {
    pose_.origin_world += dvec3(step[0], step[1], step[2]);
    const dvec3 turn(step[3], step[4], step[5]);
    constexpr double k_most_turn = 0.3;  // radians, in one step
    if (const double angle = glm::length(turn); angle > 0) {
      const dvec3 axis = turn / angle;
      const double bounded = std::min(angle, k_most_turn);
      pose_.axis_world = glm::normalize(turned(pose_.axis_world, axis, bounded));
      pose_.across_world = turned(pose_.across_world, axis, bounded);
      pose_.across_world = glm::normalize(pose_.across_world -
                                          glm::dot(pose_.across_world, pose_.axis_world) * pose_.axis_world);
    }
    pose_.opening = std::clamp(pose_.opening + step[k_opening], limits_.least_opening, limits_.most_opening);
    pose_.swing = std::clamp(pose_.swing + step[k_swing], -most_swing(), most_swing());
  }

  const Pins& pins_;
  const ClampLimits& limits_;
  ClampPose pose_;
};

}  // namespace

ClampSize size_of(ClampModel model) noexcept {
  constexpr ClampLimits k_small{.least_opening = 70, .most_opening = 180, .rocker_width = 60, .swing = 25};
  return model == ClampModel::small ? ClampSize{k_small, 95} : ClampSize{};
}

double angle_between(const dvec3& a, const dvec3& b) noexcept {
  return k_radian * deterministic_acos(std::clamp(glm::dot(a, b), -1.0, 1.0));
}

dvec3 ClampPose::rocker_world() const noexcept {
  return deterministic_cos(swing) * across_world + deterministic_sin(swing) * axis_world;
}

Pins ClampPose::tips_world(double rocker_width) const noexcept {
  const dvec3 half = 0.5 * rocker_width * rocker_world(), middle = middle_world();
  return {origin_world, middle + half, middle - half};
}

Pins ClampPose::directions_world() const noexcept {
  const dvec3 inward = deterministic_sin(swing) * across_world - deterministic_cos(swing) * axis_world;
  return {axis_world, inward, inward};
}

Result<ClampPose, LocatedError> fit_pose(const Pins& pins_world, const ClampLimits& limits) {
  if (auto error = check_pins(pins_world, limits)) return *std::move(error);
  return Fit(pins_world, limits).run();
}

}  // namespace trephine::skull_clamp
