#include "tests/bench/depth_models.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "volume/deterministic_math.h"

namespace trephine::bench {

using glm::dvec3;

namespace {
constexpr double k_two_pi = 6.283185307179586;
}

BallModel ball_of(int count) {
  const int around = std::max(8, static_cast<int>(std::sqrt(count / 1.0))), up = count / (2 * around) + 1;
  BallModel m;
  m.vertices.push_back({0, 0, k_ball_radius});
  for (int j = 1; j < up; ++j)
    for (int i = 0; i < around; ++i) {
      const double a = k_two_pi * i / around, b = 0.5 * k_two_pi * j / up;
      m.vertices.push_back(k_ball_radius *
                           dvec3(std::sin(b) * std::cos(a), std::sin(b) * std::sin(a), std::cos(b)));
    }
  m.vertices.push_back({0, 0, -k_ball_radius});
  const auto at = [&](int i, int j) { return static_cast<std::uint32_t>(1 + (j - 1) * around + i % around); };
  const auto last = static_cast<std::uint32_t>(m.vertices.size() - 1);
  const auto add = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    m.triangles.insert(m.triangles.end(), {a, b, c});
  };
  for (int i = 0; i < around; ++i) {
    add(0, at(i, 1), at(i + 1, 1));
    for (int j = 1; j + 1 < up; ++j) {
      add(at(i, j), at(i, j + 1), at(i + 1, j));
      add(at(i + 1, j), at(i, j + 1), at(i + 1, j + 1));
    }
    add(at(i, up - 1), last, at(i + 1, up - 1));
  }
  const auto wanted = 3 * static_cast<std::size_t>(count);
  for (std::size_t t = 0; m.triangles.size() + 6 <= wanted; t += 3) {
    const std::uint32_t a = m.triangles[t], b = m.triangles[t + 1], c = m.triangles[t + 2];
    m.vertices.push_back(k_ball_radius * glm::normalize(m.vertices[a] + m.vertices[b] + m.vertices[c]));
    const auto middle = static_cast<std::uint32_t>(m.vertices.size() - 1);
    m.triangles[t + 2] = middle;
    add(b, c, middle), add(c, a, middle);
  }
  while (m.triangles.size() < wanted) add(0, 0, 0);
  return m;
}

dvec3 direction(int n) {
  const auto share = [](int k) {
    return static_cast<double>(volume::hash_bits(static_cast<std::uint64_t>(k)) >> 11) * 0x1p-53;
  };
  const double z = 1 - 2 * share(2 * n), a = k_two_pi * share(2 * n + 1);
  const double r = std::sqrt(1 - z * z);
  return {r * std::cos(a), r * std::sin(a), z};
}

}  // namespace trephine::bench
