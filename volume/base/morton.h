// morton_code: a number for each point of a lattice. Near points mostly have near numbers.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>

namespace trephine::volume {

/// Returns the position of a point on the Morton curve (Morton 1966). Coordinates are 0 to 2^21 - 1.
constexpr std::uint64_t morton_code(const glm::ivec3& p) noexcept {
  const auto spread = [](int value) {
    auto x = static_cast<std::uint64_t>(value);
    x = (x | x << 32) & 0x1f00000000ffffu;
    x = (x | x << 16) & 0x1f0000ff0000ffu;
    x = (x | x << 8) & 0x100f00f00f00f00fu;
    x = (x | x << 4) & 0x10c30c30c30c30c3u;
    return (x | x << 2) & 0x1249249249249249u;
  };
  return spread(p.x) | spread(p.y) << 1 | spread(p.z) << 2;
}

}  // namespace trephine::volume
