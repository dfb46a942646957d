// Closed models of few triangles, for tests of depth images.
#pragma once

#include <cmath>
#include <cstdint>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <numbers>
#include <utility>
#include <vector>

namespace trephine::haptics::depth {

using glm::dvec3;

struct Model {
  std::vector<dvec3> vertices;
  std::vector<std::uint32_t> triangles;

  /// The model turned inside out: a cavity.
  Model inward() const {
    Model m = *this;
    for (std::size_t t = 0; t < m.triangles.size(); t += 3) std::swap(m.triangles[t], m.triangles[t + 1]);
    return m;
  }
  void add(const Model& other) {
    const auto first = static_cast<std::uint32_t>(vertices.size());
    vertices.insert(vertices.end(), other.vertices.begin(), other.vertices.end());
    for (const std::uint32_t v : other.triangles) triangles.push_back(first + v);
  }
};

inline Model box(const dvec3& low, const dvec3& high) {
  Model m;
  for (int c = 0; c < 8; ++c)
    m.vertices.push_back({c & 1 ? high.x : low.x, c & 2 ? high.y : low.y, c & 4 ? high.z : low.z});
  m.triangles = {0, 2, 1, 1, 2, 3, 4, 5, 6, 5, 7, 6, 0, 1, 4, 1, 5, 4,
                 2, 6, 3, 3, 6, 7, 0, 4, 2, 2, 4, 6, 1, 3, 5, 3, 7, 5};
  return m;
}
/// `around`: number of vertices on each circle of latitude.
inline Model ball(const dvec3& middle, double radius, int around) {
  Model m;
  const int up = around / 2;
  for (int j = 0; j <= up; ++j)
    for (int i = 0; i < around; ++i) {
      const double a = 2 * std::numbers::pi * i / around, b = std::numbers::pi * j / up;
      m.vertices.push_back(middle +
                           radius * dvec3(std::sin(b) * std::cos(a), std::sin(b) * std::sin(a), std::cos(b)));
    }
  // Triangles use one vertex at each pole.
  const auto at = [&](int i, int j) {
    return static_cast<std::uint32_t>(j == 0 || j == up ? around * j : around * j + i % around);
  };
  for (int j = 0; j < up; ++j)
    for (int i = 0; i < around; ++i) {
      if (j > 0) m.triangles.insert(m.triangles.end(), {at(i, j), at(i, j + 1), at(i + 1, j)});
      if (j + 1 < up) m.triangles.insert(m.triangles.end(), {at(i + 1, j), at(i, j + 1), at(i + 1, j + 1)});
    }
  return m;
}

/// Winding number of a model about p, from solid angles (van Oosterom and Strackee 1983): uses no ray and no
/// image.
inline double winding(const Model& m, const dvec3& p) {
  double sum = 0;
  for (std::size_t t = 0; t < m.triangles.size(); t += 3) {
    const dvec3 a = m.vertices[m.triangles[t]] - p, b = m.vertices[m.triangles[t + 1]] - p,
                c = m.vertices[m.triangles[t + 2]] - p;
    const double la = glm::length(a), lb = glm::length(b), lc = glm::length(c);
    sum += 2 * std::atan2(glm::dot(a, glm::cross(b, c)),
                          la * lb * lc + glm::dot(a, b) * lc + glm::dot(b, c) * la + glm::dot(c, a) * lb);
  }
  return sum / (4 * std::numbers::pi);
}

}  // namespace trephine::haptics::depth
