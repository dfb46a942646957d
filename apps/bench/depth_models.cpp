#include "apps/bench/depth_models.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <map>
#include <tuple>

#include "volume/base/deterministic_math.h"

namespace trephine::bench {

using glm::dvec3;

namespace {
constexpr double k_two_pi = 6.283185307179586;
}

BenchModel ball_of(int count) {
  const int around = std::max(8, static_cast<int>(std::sqrt(count / 1.0))), up = count / (2 * around) + 1;
  BenchModel m;
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
  const auto index_count = 3 * static_cast<std::size_t>(count);
  for (std::size_t t = 0; m.triangles.size() + 6 <= index_count; t += 3) {
    const std::uint32_t a = m.triangles[t], b = m.triangles[t + 1], c = m.triangles[t + 2];
    m.vertices.push_back(k_ball_radius * glm::normalize(m.vertices[a] + m.vertices[b] + m.vertices[c]));
    const auto middle = static_cast<std::uint32_t>(m.vertices.size() - 1);
    m.triangles[t + 2] = middle;
    add(b, c, middle), add(c, a, middle);
  }
  while (m.triangles.size() < index_count) add(0, 0, 0);
  return m;
}

int close_holes(BenchModel& m) {
  // Vertices at one position are merged.
  const auto less = [](const dvec3& a, const dvec3& b) {
    return std::tie(a.x, a.y, a.z) < std::tie(b.x, b.y, b.z);
  };
  std::map<dvec3, std::uint32_t, decltype(less)> first(less);
  std::vector<std::uint32_t> same;
  for (const dvec3& p : m.vertices)
    same.push_back(first.emplace(p, static_cast<std::uint32_t>(same.size())).first->second);
  for (std::uint32_t& v : m.triangles) v = same[v];
  // Directed edges (from, to) of triangles that lack the opposite edge, with their number.
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> open;
  for (std::size_t t = 0; t < m.triangles.size(); t += 3)
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t a = m.triangles[t + k], b = m.triangles[t + (k + 1) % 3];
      if (a == b) continue;
      if (const auto back = open.find({b, a}); back != open.end())
        back->second == 1 ? (void)open.erase(back) : (void)--back->second;
      else
        ++open[{a, b}];
    }
  int holes = 0;
  while (!open.empty()) {
    std::vector<std::uint32_t> loop;
    std::uint32_t at = open.begin()->first.first;
    while (true) {
      const auto next = open.lower_bound({at, 0});
      if (next == open.end() || next->first.first != at) break;
      loop.push_back(at);
      at = next->first.second;
      if (--next->second == 0) open.erase(next);
    }
    if (loop.empty()) break;
    ++holes;
    dvec3 middle(0);
    for (const std::uint32_t v : loop) middle += m.vertices[v] / static_cast<double>(loop.size());
    const auto centre = static_cast<std::uint32_t>(m.vertices.size());
    m.vertices.push_back(middle);
    for (std::size_t i = 0; i < loop.size(); ++i)
      m.triangles.insert(m.triangles.end(), {loop[(i + 1) % loop.size()], loop[i], centre});
  }
  double volume = 0;
  for (std::size_t t = 0; t < m.triangles.size(); t += 3)
    volume += glm::dot(m.vertices[m.triangles[t]],
                       glm::cross(m.vertices[m.triangles[t + 1]], m.vertices[m.triangles[t + 2]]));
  if (volume < 0)
    for (std::size_t t = 0; t < m.triangles.size(); t += 3) std::swap(m.triangles[t], m.triangles[t + 1]);
  return holes;
}

void fit(BenchModel& m, double longest_mm) {
  dvec3 low(1e300), high(-1e300);
  for (const dvec3& p : m.vertices) low = glm::min(low, p), high = glm::max(high, p);
  const dvec3 wide = high - low;
  const double scale = longest_mm / std::max({wide.x, wide.y, wide.z});
  for (dvec3& p : m.vertices) p = scale * (p - 0.5 * (low + high));
}

dvec3 direction(int n) {
  const auto share = [](int k) {
    return static_cast<double>(hash_bits(static_cast<std::uint64_t>(k)) >> 11) * 0x1p-53;
  };
  const double z = 1 - 2 * share(2 * n), a = k_two_pi * share(2 * n + 1);
  const double r = std::sqrt(1 - z * z);
  return {r * std::cos(a), r * std::sin(a), z};
}

}  // namespace trephine::bench
