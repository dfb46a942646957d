#include "haptics/mesh_tree.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <limits>
#include <numeric>

namespace trephine::haptics {

using glm::dvec3;

MeshTree::MeshTree(std::vector<dvec3> vertices, std::vector<std::uint32_t> triangles)
    : vertices_(std::move(vertices)), triangles_(std::move(triangles)) {
  const auto count = static_cast<std::uint32_t>(triangles_.size() / 3);
  if (count == 0) return;
  std::vector<dvec3> centres(count);
  double shortest = 1e300;
  for (std::uint32_t t = 0; t < count; ++t) {
    const dvec3 &a = vertices_[triangles_[3 * t]], &b = vertices_[triangles_[3 * t + 1]],
                &c = vertices_[triangles_[3 * t + 2]];
    centres[t] = (a + b + c) / 3.0;
    for (const double edge : {glm::length(b - a), glm::length(c - b), glm::length(a - c)})
      if (edge > 0) shortest = std::min(shortest, edge);
  }
  double farthest = 0;
  for (const dvec3& v : vertices_)
    farthest = std::max({farthest, std::abs(v.x), std::abs(v.y), std::abs(v.z)});
  // Well above the rounding of coordinates, however small the triangles.
  gap_ = std::clamp(1e-3 * shortest, std::min(1e-5, 1e-10 * farthest), 1e-5);
  std::vector<std::uint32_t> order(count);
  std::iota(order.begin(), order.end(), 0u);
  nodes_.reserve(count);
  build(0, count, centres, order, 0);
  std::vector<std::uint32_t> sorted(triangles_.size());
  for (std::uint32_t t = 0; t < count; ++t)
    std::copy_n(triangles_.begin() + 3 * static_cast<std::ptrdiff_t>(order[t]), 3,
                sorted.begin() + 3 * static_cast<std::ptrdiff_t>(t));
  triangles_ = std::move(sorted);
  refit(vertices_);
}

/// Halves along the longest side of the box of centres; returns the node's place.
std::uint32_t MeshTree::build(std::uint32_t begin, std::uint32_t end, std::span<const dvec3> centres,
                              std::vector<std::uint32_t>& order, int depth) {
  const auto place = static_cast<std::uint32_t>(nodes_.size());
  nodes_.push_back({dvec3(0), dvec3(0), begin, end - begin});
  if (end - begin <= k_leaf || depth == k_deepest - 2) return place;
  dvec3 low(1e300), high(-1e300);
  for (std::uint32_t i = begin; i < end; ++i) {
    low = glm::min(low, centres[order[i]]);
    high = glm::max(high, centres[order[i]]);
  }
  const dvec3 side = high - low;
  const int axis = side.x >= side.y && side.x >= side.z ? 0 : side.y >= side.z ? 1 : 2;
  const std::uint32_t middle = (begin + end) / 2;
  std::nth_element(order.begin() + begin, order.begin() + middle, order.begin() + end,
                   [&](std::uint32_t a, std::uint32_t b) {
                     return centres[a][axis] != centres[b][axis] ? centres[a][axis] < centres[b][axis]
                                                                 : a < b;
                   });
  build(begin, middle, centres, order, depth + 1);
  const std::uint32_t second = build(middle, end, centres, order, depth + 1);
  nodes_[place].first = second;
  nodes_[place].count = 0;
  return place;
}

void MeshTree::bound_leaf(Node& node) const {
  node.low = dvec3(1e300), node.high = dvec3(-1e300);
  for (std::uint32_t i = 3 * node.first; i < 3 * (node.first + node.count); ++i) {
    node.low = glm::min(node.low, vertices_[triangles_[i]]);
    node.high = glm::max(node.high, vertices_[triangles_[i]]);
  }
}

void MeshTree::refit(std::span<const dvec3> vertices) {
  if (vertices.data() != vertices_.data()) vertices_.assign(vertices.begin(), vertices.end());
  // Children come after their parents.
  for (std::size_t n = nodes_.size(); n-- > 0;) {
    Node& node = nodes_[n];
    if (node.count > 0) {
      bound_leaf(node);
    } else {
      const Node &a = nodes_[n + 1], &b = nodes_[node.first];
      node.low = glm::min(a.low, b.low);
      node.high = glm::max(a.high, b.high);
    }
  }
}

bool MeshTree::cast(const dvec3& a, const dvec3& b, bool is_front, bool is_back, FacetHit& hit,
                    int& looked) const noexcept {
  if (nodes_.empty() || a == b) return false;
  const dvec3 way = b - a;
  double nearest = std::numeric_limits<double>::infinity();
  // The box of the way, a little larger than rounding, is enough for short ways; far ones are few.
  const auto meets = [&](const Node& node) {
    double from = 0, to = std::min(1.0, nearest);
    for (int k = 0; k < 3; ++k) {
      const double slack = 1e-12 * (std::abs(a[k]) + std::abs(node.low[k]) + std::abs(node.high[k]));
      const double low = node.low[k] - slack - a[k], high = node.high[k] + slack - a[k];
      if (way[k] == 0) {
        if (low > 0 || high < 0) return false;
        continue;
      }
      const double inverse = 1 / way[k], t0 = low * inverse, t1 = high * inverse;
      from = std::max(from, std::min(t0, t1) * (1 - 1e-12) - 1e-300);
      to = std::min(to, std::max(t0, t1) * (1 + 1e-12) + 1e-300);
    }
    return from <= to;
  };
  std::array<std::uint32_t, k_deepest> stack;
  std::size_t depth = 0;
  stack[depth++] = 0;
  while (depth > 0) {
    const std::uint32_t n = stack[--depth];
    const Node& node = nodes_[n];
    if (!meets(node)) continue;
    if (node.count == 0) {
      stack[depth++] = node.first;
      stack[depth++] = n + 1;
      continue;
    }
    for (std::uint32_t i = 3 * node.first; i < 3 * (node.first + node.count); i += 3) {
      const dvec3 &p = vertices_[triangles_[i]], &q = vertices_[triangles_[i + 1]],
                  &r = vertices_[triangles_[i + 2]];
      double t = 0, facing = 0;
      ++looked;
      if (!crosses_triangle(a, way, p, q, r, t, facing) || t >= nearest) continue;
      if (facing < 0 ? !is_front : !is_back) continue;
      const dvec3 normal = glm::normalize(glm::cross(q - p, r - p));
      nearest = t;
      hit.t = t;
      hit.normal_world = facing < 0 ? normal : -normal;
      hit.side = facing < 0 ? 1 : -1;
    }
  }
  return nearest <= 1;
}

std::size_t MeshTree::bytes() const noexcept {
  return vertices_.size() * sizeof(dvec3) + triangles_.size() * sizeof(std::uint32_t) +
         nodes_.size() * sizeof(Node);
}

}  // namespace trephine::haptics
