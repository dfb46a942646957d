#include "tests/checker/mesh_judge.h"

#include <algorithm>
#include <numeric>
#include <vector>

namespace trephine::checker {

MeshVerdict judge_mesh(std::span<const glm::vec3> vertices, std::span<const std::uint32_t> triangles) {
  MeshVerdict verdict;
  struct Edge {
    std::uint32_t low, high;
    bool is_forward;
  };
  std::vector<Edge> edges;
  edges.reserve(triangles.size());
  for (std::size_t t = 0; t + 2 < triangles.size(); t += 3) {
    const std::uint32_t v[3] = {triangles[t], triangles[t + 1], triangles[t + 2]};
    if (v[0] == v[1] || v[1] == v[2] || v[2] == v[0]) ++verdict.degenerate_triangles;
    for (int i = 0; i < 3; ++i) {
      const std::uint32_t a = v[i], b = v[(i + 1) % 3];
      edges.push_back({std::min(a, b), std::max(a, b), a < b});
    }
    const glm::dvec3 p(vertices[v[0]]), q(vertices[v[1]]), r(vertices[v[2]]);
    verdict.signed_volume +=
        (p.x * (q.y * r.z - q.z * r.y) + p.y * (q.z * r.x - q.x * r.z) + p.z * (q.x * r.y - q.y * r.x)) / 6;
  }
  std::sort(edges.begin(), edges.end(),
            [](const Edge& a, const Edge& b) { return a.low != b.low ? a.low < b.low : a.high < b.high; });
  for (std::size_t i = 0; i < edges.size();) {
    std::size_t end = i, forward = 0;
    while (end < edges.size() && edges[end].low == edges[i].low && edges[end].high == edges[i].high)
      forward += edges[end++].is_forward;
    const std::size_t count = end - i;
    if (count == 1)
      ++verdict.boundary_edges;
    else if (count > 2)
      ++verdict.crowded_edges;
    else if (forward != 1)
      ++verdict.twisted_edges;
    i = end;
  }
  // A vertex is pinched when the triangles around it fall into several groups joined by edges.
  std::vector<std::uint32_t> start(vertices.size() + 1, 0);
  for (const std::uint32_t v : triangles) ++start[v + 1];
  std::partial_sum(start.begin(), start.end(), start.begin());
  std::vector<std::uint32_t> around(triangles.size()), fill(start.begin(), start.end() - 1);
  for (std::size_t i = 0; i < triangles.size(); ++i)
    around[fill[triangles[i]]++] = static_cast<std::uint32_t>(i / 3);
  for (std::size_t v = 0; v < vertices.size(); ++v) {
    const std::size_t first = start[v], count = start[v + 1] - first;
    if (count == 0) continue;
    std::vector<bool> is_reached(count, false);
    std::vector<std::size_t> todo{0};
    is_reached[0] = true;
    std::size_t reached = 0;
    while (!todo.empty()) {
      const std::size_t i = todo.back();
      todo.pop_back();
      ++reached;
      for (std::size_t j = 0; j < count; ++j) {
        if (is_reached[j]) continue;
        int shared = 0;  // vertices in common besides v
        for (int a = 0; a < 3; ++a)
          for (int b = 0; b < 3; ++b) {
            const std::uint32_t x = triangles[3 * around[first + i] + static_cast<std::size_t>(a)];
            shared += x != v && x == triangles[3 * around[first + j] + static_cast<std::size_t>(b)];
          }
        if (shared > 0) is_reached[j] = true, todo.push_back(j);
      }
    }
    if (reached != count) ++verdict.pinched_vertices;
  }
  return verdict;
}

}  // namespace trephine::checker
