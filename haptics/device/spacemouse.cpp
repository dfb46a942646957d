#include "haptics/device/spacemouse.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "haptics/device/pose_path.h"

namespace trephine::haptics {

using glm::dvec3;

namespace {

constexpr double k_full = 350;     // full deflection, in units of the reports
constexpr double k_longest = 0.1;  // s; longer times between two calls count as this time

std::int16_t word(std::span<const std::uint8_t> bytes, std::size_t i) noexcept {
  return static_cast<std::int16_t>(static_cast<std::uint16_t>(bytes[i] | bytes[i + 1] << 8));
}

std::int16_t negative(std::int16_t value) noexcept {
  return static_cast<std::int16_t>(-std::max<int>(value, -32767));
}

/// Reads three words: to the right, toward the user, down.
std::array<std::int16_t, 3> axes(std::span<const std::uint8_t> bytes) noexcept {
  return {word(bytes, 0), negative(word(bytes, 4)), word(bytes, 2)};
}

}  // namespace

bool SpaceMouseParser::add(std::span<const std::uint8_t> report) noexcept {
  if (report.empty()) return false;
  const std::span<const std::uint8_t> data = report.subspan(1);
  switch (report[0]) {
    case 1:
      if (data.size() < 6) return false;
      state_.motion = axes(data);
      if (data.size() >= 12) state_.turn = axes(data.subspan(6));
      return true;
    case 2:
      if (data.size() < 6) return false;
      state_.turn = axes(data);
      return true;
    case 3:
      if (data.empty()) return false;
      state_.buttons = 0;
      for (std::size_t i = 0; i < std::min<std::size_t>(data.size(), 4); ++i)
        state_.buttons |= static_cast<std::uint32_t>(data[i]) << 8 * i;
      return true;
    default:
      return false;
  }
}

void RatePose::move(const SpaceMouseState& state, double seconds) noexcept {
  const double dt = std::clamp(seconds, 0.0, k_longest);
  const auto rate = [&](std::int16_t deflection) {
    const double share = std::clamp(deflection / k_full, -1.0, 1.0);
    const double beyond = std::max(std::abs(share) - control_.dead_zone, 0.0) / (1 - control_.dead_zone);
    return std::copysign(beyond * beyond, share);
  };
  const auto rates = [&](const std::array<std::int16_t, 3>& axes) {
    return dvec3(rate(axes[0]), rate(axes[1]), rate(axes[2]));
  };
  position_ += control_.speed * dt * rates(state.motion);
  if (const double length = glm::length(position_); length > control_.radius)
    position_ *= control_.radius / length;
  const dvec3 half = 0.5 * control_.turning * dt * rates(state.turn);
  orientation_ = unit_of(glm::dquat(1, half.x, half.y, half.z) * orientation_);
}

}  // namespace trephine::haptics
