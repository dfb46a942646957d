#include "volume/surface/surface_facts.h"

#include <algorithm>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <numeric>
#include <vector>

namespace trephine::volume {

SurfaceFacts facts_of(std::span<const glm::dvec3> vertices, std::span<const std::uint32_t> triangles) {
  SurfaceFacts facts;
  facts.triangles = triangles.size() / 3;
  // Merge vertices with equal coordinates: STL has no shared vertices.
  std::vector<std::uint32_t> order(vertices.size()), merged(vertices.size());
  std::iota(order.begin(), order.end(), 0U);
  std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
    const glm::dvec3 &p = vertices[a], &q = vertices[b];
    return p.x != q.x ? p.x < q.x : p.y != q.y ? p.y < q.y : p.z < q.z;
  });
  glm::dvec3 low(1e300), high(-1e300);
  for (std::size_t i = 0; i < order.size(); ++i) {
    const bool is_new = i == 0 || vertices[order[i]] != vertices[order[i - 1]];
    merged[order[i]] = is_new ? order[i] : merged[order[i - 1]];
    low = glm::min(low, vertices[order[i]]);
    high = glm::max(high, vertices[order[i]]);
  }
  if (!vertices.empty()) facts.size = high - low;
  struct Edge {
    std::uint32_t low, high;
    bool is_forward;
  };
  std::vector<Edge> edges;
  edges.reserve(triangles.size());
  for (std::size_t t = 0; t + 2 < triangles.size(); t += 3) {
    const std::uint32_t v[3] = {merged[triangles[t]], merged[triangles[t + 1]], merged[triangles[t + 2]]};
    facts.volume += glm::dot(vertices[v[0]], glm::cross(vertices[v[1]], vertices[v[2]])) / 6;
    if (v[0] == v[1] || v[1] == v[2] || v[2] == v[0]) continue;  // no area
    for (int k = 0; k < 3; ++k) {
      const std::uint32_t a = v[k], b = v[(k + 1) % 3];
      edges.push_back({std::min(a, b), std::max(a, b), a < b});
    }
  }
  const auto is_same_edge = [](const Edge& a, const Edge& b) { return a.low == b.low && a.high == b.high; };
  std::sort(edges.begin(), edges.end(),
            [](const Edge& a, const Edge& b) { return a.low != b.low ? a.low < b.low : a.high < b.high; });
  for (std::size_t i = 0, end = 0; i < edges.size(); i = end) {
    std::size_t forward_count = 0;
    for (end = i; end < edges.size() && is_same_edge(edges[i], edges[end]); ++end)
      forward_count += edges[end].is_forward;
    const std::size_t triangle_count = end - i;
    facts.open_edges += triangle_count == 1;
    facts.non_manifold_edges += triangle_count > 2;
    facts.misoriented_edges += triangle_count == 2 && forward_count != 1;
  }
  return facts;
}

}  // namespace trephine::volume
