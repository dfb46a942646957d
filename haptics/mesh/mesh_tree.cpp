#include "haptics/mesh/mesh_tree.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <limits>
#include <numeric>

namespace trephine::haptics {

using glm::dvec3;

namespace {
constexpr int k_max_newton = 32;
constexpr double k_near = 1e-12;  // of the way: nearer than this is met

/// May a + t way, t in [0, most], come within `radius` of the box? A little larger than rounding.
bool meets_box(const dvec3& a, const dvec3& way, double most, const dvec3& box_low, const dvec3& box_high,
               double radius) noexcept {
  double from = 0, to = most;
  for (int k = 0; k < 3; ++k) {
    const double slack = radius + 1e-12 * (std::abs(a[k]) + std::abs(box_low[k]) + std::abs(box_high[k]));
    const double low = box_low[k] - slack - a[k], high = box_high[k] + slack - a[k];
    if (way[k] == 0) {
      if (low > 0 || high < 0) return false;
      continue;
    }
    const double inverse = 1 / way[k], t0 = low * inverse, t1 = high * inverse;
    from = std::max(from, std::min(t0, t1) * (1 - 1e-12) - 1e-300);
    to = std::min(to, std::max(t0, t1) * (1 + 1e-12) + 1e-300);
  }
  return from <= to;
}
}  // namespace

MeshTree::MeshTree(std::vector<dvec3> vertices, std::vector<std::uint32_t> triangles, Order order_of)
    : vertices_(std::move(vertices)), triangles_(std::move(triangles)) {
  const auto count = static_cast<std::uint32_t>(triangles_.size() / 3);
  if (count == 0) return;
  std::vector<dvec3> centres(order_of == Order::by_place ? count : 0);
  double shortest = 1e300;
  for (std::uint32_t t = 0; t < count; ++t) {
    const dvec3 &a = vertices_[triangles_[3 * t]], &b = vertices_[triangles_[3 * t + 1]],
                &c = vertices_[triangles_[3 * t + 2]];
    if (!centres.empty()) centres[t] = (a + b + c) / 3.0;
    for (const dvec3& edge : {b - a, c - b, a - c})
      if (const double square = glm::dot(edge, edge); square > 0) shortest = std::min(shortest, square);
  }
  shortest = std::sqrt(shortest);
  double farthest = 0;
  for (const dvec3& v : vertices_)
    farthest = std::max({farthest, std::abs(v.x), std::abs(v.y), std::abs(v.z)});
  // Well above the rounding of coordinates, however small the triangles.
  gap_ = std::clamp(1e-3 * shortest, std::min(1e-5, 1e-10 * farthest), 1e-5);
  std::vector<std::uint32_t> order(count);
  std::iota(order.begin(), order.end(), 0u);
  nodes_.reserve(count);
  build(0, count, centres, order, 0);
  if (order_of == Order::as_given) {
    refit(vertices_);
    return;
  }
  std::vector<std::uint32_t> sorted(triangles_.size());
  for (std::uint32_t t = 0; t < count; ++t)
    std::copy_n(triangles_.begin() + 3 * static_cast<std::ptrdiff_t>(order[t]), 3,
                sorted.begin() + 3 * static_cast<std::ptrdiff_t>(t));
  triangles_ = std::move(sorted);
  refit(vertices_);
}

/// Halves; returns the node's place.
std::uint32_t MeshTree::build(std::uint32_t begin, std::uint32_t end, std::span<const dvec3> centres,
                              std::vector<std::uint32_t>& order, int depth) {
  const auto place = static_cast<std::uint32_t>(nodes_.size());
  nodes_.push_back({dvec3(0), dvec3(0), begin, end - begin});
  if (end - begin <= k_leaf || depth == k_deepest - 2) {
    // In their own order, so that a tree of what this one holds is the same: it halves at the same places.
    std::sort(order.begin() + begin, order.begin() + end);
    return place;
  }
  const std::uint32_t middle = (begin + end) / 2;
  if (!centres.empty()) split(begin, middle, end, centres, order);
  build(begin, middle, centres, order, depth + 1);
  const std::uint32_t second = build(middle, end, centres, order, depth + 1);
  nodes_[place].first = second;
  nodes_[place].count = 0;
  return place;
}

/// Along the longest side of the box of centres.
void MeshTree::split(std::uint32_t begin, std::uint32_t middle, std::uint32_t end,
                     std::span<const dvec3> centres, std::vector<std::uint32_t>& order) {
  dvec3 low(1e300), high(-1e300);
  for (std::uint32_t i = begin; i < end; ++i) {
    low = glm::min(low, centres[order[i]]);
    high = glm::max(high, centres[order[i]]);
  }
  const dvec3 side = high - low;
  const int axis = side.x >= side.y && side.x >= side.z ? 0 : side.y >= side.z ? 1 : 2;
  std::nth_element(order.begin() + begin, order.begin() + middle, order.begin() + end,
                   [&](std::uint32_t a, std::uint32_t b) {
                     return centres[a][axis] != centres[b][axis] ? centres[a][axis] < centres[b][axis]
                                                                 : a < b;
                   });
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
  if (a == b) return false;
  const dvec3 way = b - a;
  double nearest = std::numeric_limits<double>::infinity();
  const auto meets = [&](const Node& node) {
    return meets_box(a, way, std::min(1.0, nearest), node.low, node.high, 0);
  };
  for_triangles(meets, [&](std::uint32_t i) {
    const auto [p, q, r] = corners(i);
    double t = 0, facing = 0;
    ++looked;
    if (!crosses_triangle(a, way, p, q, r, t, facing) || t >= nearest) return;
    if (facing < 0 ? !is_front : !is_back) return;
    const dvec3 normal = glm::normalize(glm::cross(q - p, r - p));
    nearest = t;
    hit.t = t;
    hit.normal_world = facing < 0 ? normal : -normal;
    hit.side = side_of(facing >= 0);
    hit.triangle = i;
  });
  return nearest <= 1;
}

dvec3 nearest_on_triangle(const dvec3& p, const dvec3& a, const dvec3& b, const dvec3& c,
                          TriangleFeature* feature) noexcept {
  const auto on = [feature](TriangleFeature f, const dvec3& q) {
    if (feature) *feature = f;
    return q;
  };
  using enum TriangleFeature;
  const dvec3 ab = b - a, ac = c - a, ap = p - a;
  const double d1 = glm::dot(ab, ap), d2 = glm::dot(ac, ap);
  if (d1 <= 0 && d2 <= 0) return on(corner, a);
  const dvec3 bp = p - b;
  const double d3 = glm::dot(ab, bp), d4 = glm::dot(ac, bp);
  if (d3 >= 0 && d4 <= d3) return on(corner, b);
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) return on(edge_ab, a + d1 / (d1 - d3) * ab);
  const dvec3 cp = p - c;
  const double d5 = glm::dot(ab, cp), d6 = glm::dot(ac, cp);
  if (d6 >= 0 && d5 <= d6) return on(corner, c);
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0) return on(edge_ac, a + d2 / (d2 - d6) * ac);
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0)
    return on(edge_bc, b + (d4 - d3) / ((d4 - d3) + (d5 - d6)) * (c - b));
  const double share = 1 / (va + vb + vc);
  return on(face, a + (vb * share) * ab + (vc * share) * ac);
}

bool MeshTree::cast_ball(const dvec3& a, const dvec3& b, double radius, bool is_front, bool is_back,
                         FacetHit& hit, int& looked) const noexcept {
  if (a == b) return false;
  const dvec3 way = b - a;
  const double length = glm::length(way);
  double nearest = std::numeric_limits<double>::infinity();
  const auto meets = [&](const Node& node) {
    return meets_box(a, way, std::min(1.0, nearest), node.low, node.high, radius);
  };
  for_triangles(meets, [&](std::uint32_t i) {
    const auto [p, q, r] = corners(i);
    const dvec3 across = glm::cross(q - p, r - p);
    if (!(glm::dot(across, across) > 0)) return;  // degenerate
    const bool is_before = glm::dot(across, a - p) >= 0;
    if (is_before ? !is_front : !is_back) return;
    ++looked;
    // The distance to a triangle, which is convex, is convex along the way: Newton's steps from before the
    // first crossing never pass it, and once it rises nothing is met any more.
    double t = 0;
    for (int k = 0; k < k_max_newton; ++k) {
      const dvec3 at = a + t * way, off = at - nearest_on_triangle(at, p, q, r);
      const double distance = glm::length(off), approach = -glm::dot(off, way);
      if (!(approach > 0)) return;  // goes past, or away
      const double left = distance - radius;
      if (left <= k_near * length || k + 1 == k_max_newton) {
        if (t >= nearest) return;
        nearest = t;
        hit.t = t;
        hit.normal_world = distance > 0 ? off / distance : glm::normalize(-way);
        hit.side = side_of(!is_before);
        hit.triangle = i;
        return;
      }
      t += left * distance / approach;
      if (!(t <= 1 && t < nearest)) return;
    }
  });
  return nearest <= 1;
}

std::size_t MeshTree::bytes() const noexcept {
  return vertices_.size() * sizeof(dvec3) + triangles_.size() * sizeof(std::uint32_t) +
         nodes_.size() * sizeof(Node);
}

}  // namespace trephine::haptics
