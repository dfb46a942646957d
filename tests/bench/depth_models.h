// Balls of exactly so many triangles.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <vector>

namespace trephine::bench {

inline constexpr double k_ball_radius = 40;  // mm

struct BallModel {
  std::vector<glm::dvec3> vertices;
  std::vector<std::uint32_t> triangles;
};
/// Rings and poles, some triangles split in three, and where the number is odd, as published ones are, one
/// more without an area: a closed surface has an even number.
BallModel ball_of(int triangles);
/// Places all over a ball, by their numbers. Unit.
glm::dvec3 direction(int n);

}  // namespace trephine::bench
