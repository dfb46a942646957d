#include "modules/measurement/marked.h"

#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>

namespace trephine::measurement {

using glm::dvec2;
using glm::dvec3;

namespace {

/// Triangles around each corner.
struct TrianglesOfCorner {
  std::vector<std::uint32_t> first, triangles;
  explicit TrianglesOfCorner(const haptics::Surface& surface) : first(surface.vertices().size() + 1, 0) {
    const std::vector<std::uint32_t>& corners = surface.triangles();
    for (const std::uint32_t c : corners) ++first[c + 1];
    for (std::size_t i = 1; i < first.size(); ++i) first[i] += first[i - 1];
    std::vector<std::uint32_t> next(first.begin(), first.end() - 1);
    triangles.resize(corners.size());
    for (std::size_t i = 0; i < corners.size(); ++i)
      triangles[next[corners[i]]++] = static_cast<std::uint32_t>(i / 3);
  }
  /// Returns the triangles for which `is_wanted` returns true and that a chain of such triangles with common
  /// corners connects to a triangle of `open`.
  template <class Wanted>
  std::vector<std::uint32_t> flood(const haptics::Surface& surface, std::vector<std::uint32_t> open,
                                   const Wanted& is_wanted) const {
    std::vector<bool> visited(surface.triangles().size() / 3, false);
    std::vector<std::uint32_t> result;
    for (const std::uint32_t t : open) visited[t] = true;
    while (!open.empty()) {
      const std::uint32_t t = open.back();
      open.pop_back();
      if (!is_wanted(t)) continue;
      result.push_back(t);
      for (std::size_t k = 0; k < 3; ++k) {
        const std::uint32_t corner = surface.triangles()[3 * t + k];
        for (std::uint32_t i = first[corner]; i < first[corner + 1]; ++i)
          if (!visited[triangles[i]]) visited[triangles[i]] = true, open.push_back(triangles[i]);
      }
    }
    return result;
  }
};

std::array<dvec3, 3> corners_of(const haptics::Surface& surface, std::uint32_t t) {
  const auto& v = surface.vertices();
  const auto& c = surface.triangles();
  return {v[c[3 * t]], v[c[3 * t + 1]], v[c[3 * t + 2]]};
}
/// Returns the outward normal of a triangle; its length is twice the triangle's area.
dvec3 area_vector(const std::array<dvec3, 3>& c) { return glm::cross(c[1] - c[0], c[2] - c[0]); }

bool is_within(const std::vector<dvec2>& polygon, const dvec2& p) {
  bool is_in = false;
  for (std::size_t i = 0, j = polygon.size() - 1; i < polygon.size(); j = i++) {
    const dvec2 &a = polygon[i], &b = polygon[j];
    if ((a.y > p.y) != (b.y > p.y) && p.x < (b.x - a.x) * (p.y - a.y) / (b.y - a.y) + a.x) is_in = !is_in;
  }
  return is_in;
}

}  // namespace

std::optional<double> area_within(const haptics::Surface& surface,
                                  std::span<const haptics::Surface::Point> points,
                                  const std::vector<dvec3>& outline) {
  dvec3 normal(0.0), outward(0.0);
  for (std::size_t i = 0; i < outline.size(); ++i)
    normal += glm::cross(outline[i] - outline[0], outline[(i + 1) % outline.size()] - outline[0]);
  for (const haptics::Surface::Point& point : points)
    outward += glm::normalize(area_vector(corners_of(surface, point.triangle)));
  if (!(glm::length(normal) > 0)) return 0.0;
  normal = glm::normalize(glm::dot(normal, outward) < 0 ? -normal : normal);
  const dvec3 across = std::abs(normal.x) < 0.7 ? dvec3(1, 0, 0) : dvec3(0, 1, 0);
  const dvec3 u = glm::normalize(glm::cross(normal, across)), v = glm::cross(normal, u);
  const auto project = [&](const dvec3& p) { return dvec2(glm::dot(p, u), glm::dot(p, v)); };
  std::vector<dvec2> polygon;
  for (const dvec3& p : outline) polygon.push_back(project(p));

  constexpr int k_parts = 6;         // a triangle is sampled in 36 parts
  constexpr double k_turned = 0.12;  // cosine to the plane's normal: a steeper triangle turns away
  double area = 0;
  bool turns_away = false;
  std::vector<std::uint32_t> open;
  for (const haptics::Surface::Point& point : points) open.push_back(point.triangle);
  const TrianglesOfCorner triangles_of_corner(surface);
  triangles_of_corner.flood(surface, open, [&](std::uint32_t t) {
    const auto c = corners_of(surface, t);
    int inside = 0;
    for (int i = 0; i < k_parts; ++i)
      for (int j = 0; i + j < k_parts; ++j)
        for (int up = 0; up < (i + j < k_parts - 1 ? 2 : 1); ++up) {
          const double s = (i + (up ? 2.0 : 1.0) / 3) / k_parts, r = (j + (up ? 2.0 : 1.0) / 3) / k_parts;
          inside += is_within(polygon, project(c[0] + s * (c[1] - c[0]) + r * (c[2] - c[0])));
        }
    if (inside == 0) {
      // The flood passes through a triangle outside the outline only if it contains one of `points`.
      for (const haptics::Surface::Point& point : points)
        if (point.triangle == t) return true;
      return false;
    }
    const dvec3 area_normal = area_vector(c);
    const double size = glm::length(area_normal);
    if (size > 0 && glm::dot(area_normal, normal) < k_turned * size) {
      turns_away = turns_away || inside == k_parts * k_parts;
      return false;
    }
    area += 0.5 * size * inside / (k_parts * k_parts);
    return true;
  });
  return turns_away ? std::nullopt : std::optional(area);
}

MarkedPart part_of(const haptics::Surface& surface, std::uint32_t triangle, const dvec3& position) {
  MarkedPart part;
  const TrianglesOfCorner triangles_of_corner(surface);
  for (const std::uint32_t t :
       triangles_of_corner.flood(surface, {triangle}, [](std::uint32_t) { return true; })) {
    const auto c = corners_of(surface, t);
    part.area += 0.5 * glm::length(area_vector(c));
    part.volume += glm::dot(c[0] - position, area_vector(c)) / 6;
    for (const dvec3& p : c) part.farthest = std::max(part.farthest, glm::length(p - position));
  }
  return part;
}

}  // namespace trephine::measurement
