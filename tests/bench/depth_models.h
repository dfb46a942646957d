// Models for benchmarks: balls of exactly so many triangles, and real ones made closed.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <string>
#include <vector>

namespace trephine::bench {

inline constexpr double k_ball_radius = 40;  // mm

struct BenchModel {
  std::string name;
  std::vector<glm::dvec3> vertices;
  std::vector<std::uint32_t> triangles;
};
/// Rings and poles, some triangles split in three, and where the number is odd, as published ones are, one
/// more without an area: a closed surface has an even number.
BenchModel ball_of(int triangles);
/// Each loop of open edges gets a fan around its middle; how many. Then the model looks out.
int close_holes(BenchModel& model);
/// In its middle, as long in its longest direction.
void fit(BenchModel& model, double longest_mm);
/// Places all over a ball, by their numbers. Unit.
glm::dvec3 direction(int n);

}  // namespace trephine::bench
