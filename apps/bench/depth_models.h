// Models for benchmarks: balls with an exact number of triangles, and real models, whose holes are filled.
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
/// Returns a ball with exactly `triangles` triangles. Some triangles are split into three to reach this
/// number. If the number is odd, as in published models, one triangle of zero area is added, because a closed
/// surface has an even number of triangles.
BenchModel ball_of(int triangles);
/// Fills each loop of open edges with a fan around its centre, and makes the model face outward; returns the
/// number of loops.
int close_holes(BenchModel& model);
/// Centres the model and scales its longest dimension to `longest_mm`.
void fit(BenchModel& model, double longest_mm);
/// Returns the n-th of a fixed sequence of random unit vectors.
glm::dvec3 direction(int n);

}  // namespace trephine::bench
