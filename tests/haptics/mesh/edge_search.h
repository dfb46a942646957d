// Shortest lines along surfaces by graph search: the judge of surface_line().
#pragma once

#include <glm/geometric.hpp>
#include <limits>
#include <map>
#include <queue>

#include "haptics/mesh/surface_line.h"

namespace trephine::haptics {

/// Returns the length of the shortest path in a graph (Dijkstra's search). Its nodes are the vertices and
/// seven points on each edge; all nodes of a triangle are connected. This length is never less than that of
/// the shortest line on the surface, and close to it.
inline double edge_path_length(const Surface& surface, const Surface::Point& from, const Surface::Point& to) {
  constexpr int k_points = 7;
  const auto& triangles = surface.triangles();
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::size_t> edges;
  std::vector<glm::dvec3> points = surface.vertices();
  std::vector<std::vector<std::size_t>> on_triangle(triangles.size() / 3);
  for (std::size_t t = 0; t < on_triangle.size(); ++t)
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t a = triangles[3 * t + k], b = triangles[3 * t + (k + 1) % 3];
      const auto [at, is_new] = edges.emplace(std::minmax(a, b), points.size());
      if (is_new)
        for (int i = 1; i <= k_points; ++i)
          points.push_back(surface.vertices()[at->first.first] +
                           i / (k_points + 1.0) *
                               (surface.vertices()[at->first.second] - surface.vertices()[at->first.first]));
      on_triangle[t].push_back(a);
      for (std::size_t i = 0; i < k_points; ++i) on_triangle[t].push_back(at->second + i);
    }
  std::vector<std::vector<std::uint32_t>> around(points.size() + 2);
  points.push_back(from.at), points.push_back(to.at);
  on_triangle[from.triangle].push_back(points.size() - 2);
  on_triangle[to.triangle].push_back(points.size() - 1);
  for (std::uint32_t t = 0; t < on_triangle.size(); ++t)
    for (const std::size_t p : on_triangle[t]) around[p].push_back(t);
  std::vector<double> lengths(points.size(), std::numeric_limits<double>::infinity());
  using Item = std::pair<double, std::size_t>;
  std::priority_queue<Item, std::vector<Item>, std::greater<>> queue;
  lengths[points.size() - 2] = 0;
  queue.push({0, points.size() - 2});
  while (!queue.empty()) {
    const auto [so_far, p] = queue.top();
    queue.pop();
    if (p == points.size() - 1) return so_far;
    if (so_far > lengths[p]) continue;
    for (const std::uint32_t t : around[p])
      for (const std::size_t q : on_triangle[t]) {
        const double longer = so_far + glm::length(points[q] - points[p]);
        if (longer < lengths[q]) lengths[q] = longer, queue.push({longer, q});
      }
  }
  return lengths.back();
}

}  // namespace trephine::haptics
