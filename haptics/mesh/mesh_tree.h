// MeshTree: triangles in a tree of boxes. Finds the first triangle on a motion, and the triangles near a
// point. All computations are in double precision, so that a mesh may be metres wide or have edges of 10 um.
// Motions of points do not pass between triangles at their edges and vertices.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <span>
#include <utility>
#include <vector>

#include "haptics/mesh/facet_hit.h"

namespace trephine::haptics {

/// Part of a triangle on which a point is: the interior, a corner or an edge.
enum class TriangleFeature { face, corner, edge_ab, edge_bc, edge_ac };
/// Returns the point of triangle (a, b, c) nearest to p (Ericson 2005, 5.1.5). `feature`: output, may be
/// null.
inline glm::dvec3 nearest_on_triangle(const glm::dvec3& p, const glm::dvec3& a, const glm::dvec3& b,
                                      const glm::dvec3& c, TriangleFeature* feature = nullptr) noexcept {
  const auto on = [feature](TriangleFeature f, const glm::dvec3& q) {
    if (feature) *feature = f;
    return q;
  };
  using enum TriangleFeature;
  const glm::dvec3 ab = b - a, ac = c - a, ap = p - a;
  const double d1 = glm::dot(ab, ap), d2 = glm::dot(ac, ap);
  if (d1 <= 0 && d2 <= 0) return on(corner, a);
  const glm::dvec3 bp = p - b;
  const double d3 = glm::dot(ab, bp), d4 = glm::dot(ac, bp);
  if (d3 >= 0 && d4 <= d3) return on(corner, b);
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) return on(edge_ab, a + d1 / (d1 - d3) * ab);
  const glm::dvec3 cp = p - c;
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

/// Immutable except for refit(). Queries: any thread, no allocation.
class MeshTree {
 public:
  MeshTree() = default;
  /// Triangles are counter-clockwise as viewed from the free side. Degenerate triangles are kept, but no
  /// query finds them. Cost: n log n.
  MeshTree(std::vector<glm::dvec3> vertices, std::vector<std::uint32_t> triangles)
      : MeshTree(std::move(vertices), std::move(triangles), {}) {}
  /// Builds from triangles in spatial order, in a quarter of the time. `codes`: Morton codes in ascending
  /// order, one per two triangles. Codes with the same leading bits are in the same cube (Morton 1966), and
  /// the nodes are these cubes (Lauterbach and others 2009).
  static MeshTree of_ordered(std::vector<glm::dvec3> vertices, std::vector<std::uint32_t> triangles,
                             std::span<const std::uint64_t> codes) {
    return {std::move(vertices), std::move(triangles), codes};
  }

  /// Moves the vertices and updates the boxes; the nodes and gap() do not change. Do not call while another
  /// thread reads the tree.
  void refit(std::span<const glm::dvec3> vertices);

  /// Finds the first triangle that a ball meets on a blocking side while its centre moves from a to b (mm). A
  /// ball of radius 0 (mm) is a point. Sets all of `hit` except `shape`; the normal is in the frame of the
  /// tree. Adds the number of tested triangles to `visited`. `latest`: share of the motion after which the
  /// hits of a ball need not be found.
  bool cast(const glm::dvec3& a, const glm::dvec3& b, double radius, bool is_front, bool is_back,
            FacetHit& hit, int& visited, double latest = 1) const noexcept {
    return radius > 0 ? cast_ball(a, b, radius, is_front, is_back, hit, visited, latest)
                      : cast(a, b, is_front, is_back, hit, visited);
  }
  /// As above, for a point.
  bool cast(const glm::dvec3& a, const glm::dvec3& b, bool is_front, bool is_back, FacetHit& hit,
            int& visited) const noexcept;

  /// As above, for a ball: finds the first position of the centre at a distance of `radius` from a triangle.
  /// A ball that is already nearer is stopped where it would approach further. The ball meets the front of a
  /// triangle if the centre starts before the front, else the back. The normal points from the triangle to
  /// the centre.
  bool cast_ball(const glm::dvec3& a, const glm::dvec3& b, double radius, bool is_front, bool is_back,
                 FacetHit& hit, int& visited, double latest = 1) const noexcept;

  /// A triangle near a point.
  struct Near {
    std::uint32_t triangle;  ///< for corners()
    glm::dvec3 nearest;      ///< its point nearest to the query point
    glm::dvec3 normal;       ///< unit, of its front
    double distance;         ///< mm
    bool is_front;           ///< the query point is before its front
  };
  /// Calls use(near) for each triangle within `reach` mm of p, in any order, without degenerate triangles.
  /// `use` may reduce the variable `reach`.
  template <class Use>
  void for_near(const glm::dvec3& p, const double& reach, Use&& use) const noexcept;
  /// A triangle that is not degenerate.
  struct Facet {
    std::uint32_t triangle;
    std::array<glm::dvec3, 3> corners;
    glm::dvec3 normal;                     ///< unit
    std::array<glm::dvec3, 3> out_normal;  ///< of the edge from each corner to the next: unit, in the plane

    Facet() noexcept {}
    Facet(std::uint32_t index, const std::array<glm::dvec3, 3>& points,
          const glm::dvec3& unit_normal) noexcept
        : triangle(index), corners(points), normal(unit_normal) {
      for (std::size_t k = 0; k < 3; ++k)
        out_normal[k] = glm::normalize(glm::cross(corners[(k + 1) % 3] - corners[k], normal));
    }
    /// Returns false only if the distance of p is more than `reach`. Faster than the distance.
    bool may_be_within(const glm::dvec3& p, double reach) const noexcept {
      const double most = reach * (1 + 1e-9) + k_rounding;
      if (!(std::abs(glm::dot(normal, p - corners[0])) <= most)) return false;
      for (std::size_t k = 0; k < 3; ++k)
        if (!(glm::dot(out_normal[k], p - corners[k]) <= most)) return false;
      return true;
    }
    static constexpr double k_rounding = 1e-9;  ///< mm
  };
  /// Finds the triangles within `reach` mm of p and stores them. Returns their number; more than
  /// `facets.size()`: they do not fit, and some were not found.
  std::size_t find_near(const glm::dvec3& p, double reach, std::span<Facet> facets) const noexcept;
  /// As for_near(), for the triangles of a list.
  template <class Use>
  static void for_near(std::span<const Facet> facets, const glm::dvec3& p, const double& reach, Use&& use) {
    for (const Facet& facet : facets) {
      if (!facet.may_be_within(p, reach)) continue;
      const auto& [a, b, c] = facet.corners;
      const glm::dvec3 nearest = nearest_on_triangle(p, a, b, c);
      const double distance = glm::length(p - nearest);
      if (distance <= reach)
        use(Near{facet.triangle, nearest, facet.normal, distance, glm::dot(facet.normal, p - a) >= 0});
    }
  }
  /// Calls use(near) for triangles within `reach` mm of p that are at most `tie` mm farther than the nearest
  /// one found before. All triangles nearest to p are among them.
  template <class Use>
  void for_nearest(const glm::dvec3& p, double reach, double tie, Use&& use) const noexcept;
  /// Walks from a triangle to neighbours that contain its point nearest to p, as long as a neighbour is
  /// nearer to p, and returns the last triangle. Stops after about k_max_connected tested triangles, and adds
  /// their number to `visited`.
  std::uint32_t nearest_connected(std::uint32_t triangle, const glm::dvec3& p, int& visited) const noexcept;
  static constexpr int k_max_connected = 256;
  /// Returns true if a triangle is within `reach` mm of p.
  bool is_near(const glm::dvec3& p, double reach) const noexcept;
  std::array<glm::dvec3, 3> corners(std::uint32_t triangle) const noexcept {
    return {vertices_[triangles_[3 * triangle]], vertices_[triangles_[3 * triangle + 1]],
            vertices_[triangles_[3 * triangle + 2]]};
  }
  /// Bounds of all triangles, mm; low > high if there are no triangles.
  glm::dvec3 low() const noexcept { return nodes_.empty() ? glm::dvec3(1) : nodes_[0].low; }
  glm::dvec3 high() const noexcept { return nodes_.empty() ? glm::dvec3(-1) : nodes_[0].high; }

  std::size_t triangle_count() const noexcept { return triangles_.size() / 3; }
  /// The public constructor makes an identical tree, to the bit, from the vertices and triangles of a tree
  /// that it made, unless refit() moved the vertices.
  const std::vector<glm::dvec3>& vertices() const noexcept { return vertices_; }
  const std::vector<std::uint32_t>& triangles() const noexcept { return triangles_; }
  std::size_t bytes() const noexcept;
  /// Returns the distance (mm) that a god-object keeps from facets: a thousandth of the shortest edge, at
  /// most 1e-5, and large enough for the rounding of coordinates.
  double gap() const noexcept { return gap_; }

 private:
  struct Node {
    glm::dvec3 low, high;
    std::uint32_t first;  ///< first triangle, or the second child (the first one follows its parent)
    std::uint32_t count;  ///< number of triangles; 0: an inner node
  };
  static constexpr std::uint32_t k_leaf = 4;
  MeshTree(std::vector<glm::dvec3> vertices, std::vector<std::uint32_t> triangles,
           std::span<const std::uint64_t> codes);
  static constexpr int k_deepest = 64;

  /// Input of the build. The nodes are split by `centres`, or by `codes` if there are any.
  struct Guide {
    std::vector<glm::dvec3> centres;
    std::span<const std::uint64_t> codes;
    std::vector<std::uint32_t> order;  ///< indices of triangles, in the order of the leaves
  };
  std::uint32_t build(std::uint32_t begin, std::uint32_t end, Guide& guide, int depth);
  static void split(std::uint32_t begin, std::uint32_t middle, std::uint32_t end,
                    std::span<const glm::dvec3> centres, std::vector<std::uint32_t>& order);
  void bound_leaf(Node& node) const;
  /// Calls use(triangle) for the triangles of the leaves below nodes that `meets` accepts.
  template <class Meets, class Use>
  void for_triangles(Meets&& meets, Use&& use) const noexcept;
  /// Returns false if the triangle is farther than `reach`, or degenerate.
  bool nearest_on(std::uint32_t triangle, const glm::dvec3& p, double reach, Near& near) const noexcept;
  static double square_to(const Node& node, const glm::dvec3& p) noexcept {
    const glm::dvec3 off = p - glm::clamp(p, node.low, node.high);
    return glm::dot(off, off);
  }

  std::vector<glm::dvec3> vertices_;
  std::vector<std::uint32_t> triangles_;  ///< in the order of the leaves
  std::vector<Node> nodes_;
  double gap_ = 1e-5;
};

inline bool MeshTree::nearest_on(std::uint32_t triangle, const glm::dvec3& p, double reach,
                                 Near& near) const noexcept {
  const auto [a, b, c] = corners(triangle);
  const glm::dvec3 nearest = nearest_on_triangle(p, a, b, c);
  const double distance = glm::length(p - nearest);
  if (!(distance <= reach)) return false;
  const glm::dvec3 normal = glm::cross(b - a, c - a);
  const double size = glm::length(normal);
  if (!(size > 0)) return false;
  near = {triangle, nearest, normal / size, distance, glm::dot(normal, p - a) >= 0};
  return true;
}

template <class Meets, class Use>
void MeshTree::for_triangles(Meets&& meets, Use&& use) const noexcept {
  if (nodes_.empty()) return;
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
    for (std::uint32_t t = node.first; t < node.first + node.count; ++t) use(t);
  }
}

template <class Use>
void MeshTree::for_near(const glm::dvec3& p, const double& reach, Use&& use) const noexcept {
  for_triangles([&](const Node& node) { return square_to(node, p) <= reach * reach; },
                [&](std::uint32_t t) {
                  if (Near near; nearest_on(t, p, reach, near)) use(near);
                });
}

template <class Use>
void MeshTree::for_nearest(const glm::dvec3& p, double reach, double tie, Use&& use) const noexcept {
  if (nodes_.empty()) return;
  struct Waiting {
    std::uint32_t node;
    double square;
  };
  std::array<Waiting, k_deepest> stack;
  std::size_t depth = 0;
  stack[depth++] = {0, square_to(nodes_[0], p)};
  double within = reach;
  while (depth > 0) {
    const auto [n, square] = stack[--depth];
    if (!(square <= within * within)) continue;
    const Node& node = nodes_[n];
    for (std::uint32_t t = node.first; t < node.first + node.count; ++t) {
      Near near;
      if (!nearest_on(t, p, within, near)) continue;
      use(near);
      within = std::min(within, near.distance + tie);
    }
    if (node.count > 0) continue;
    // Visits the nearer child first.
    Waiting first{n + 1, square_to(nodes_[n + 1], p)}, second{node.first, square_to(nodes_[node.first], p)};
    if (second.square < first.square) std::swap(first, second);
    stack[depth++] = second;
    stack[depth++] = first;
  }
}

}  // namespace trephine::haptics
