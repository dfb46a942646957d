#include "haptics/mesh/mesh_tree.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <limits>
#include <numeric>

#include "haptics/mesh/god_object.h"

namespace trephine::haptics {

using glm::dvec3;

namespace {
constexpr int k_max_newton = 32;
constexpr double k_near = 1e-12;  // fraction of the motion; a nearer triangle counts as touched

/// Tests boxes against the motion of a ball, with tolerances a little above rounding.
class BoxTest {
 public:
  /// `low`, `high`: bounds of all boxes.
  BoxTest(const dvec3& a, const dvec3& motion, double radius, const dvec3& low, const dvec3& high) noexcept
      : a_(a), motion_(motion), inverse_(1.0 / motion) {
    const dvec3 far = glm::max(glm::abs(low), glm::abs(high));
    slack_ = radius + 1e-12 * (glm::abs(a) + glm::abs(motion) + far);
    low_ = glm::min(a, a + motion) - slack_;
    high_ = glm::max(a, a + motion) + slack_;
  }
  /// Returns true if the motion, up to its share `max_share`, may meet the box.
  bool meets(const dvec3& low, const dvec3& high, double max_share) const noexcept {
    // Most boxes are outside the bounds of the whole motion.
    if (low.x > high_.x || high.x < low_.x || low.y > high_.y || high.y < low_.y || low.z > high_.z ||
        high.z < low_.z)
      return false;
    double from = 0, to = max_share;
    for (int k = 0; k < 3; ++k) {
      if (motion_[k] == 0) continue;
      const double t0 = (low[k] - slack_[k] - a_[k]) * inverse_[k],
                   t1 = (high[k] + slack_[k] - a_[k]) * inverse_[k];
      from = std::max(from, std::min(t0, t1) * (1 - 1e-12) - 1e-300);
      to = std::min(to, std::max(t0, t1) * (1 + 1e-12) + 1e-300);
    }
    return from <= to;
  }

 private:
  dvec3 a_, motion_, inverse_, slack_, low_, high_;
};
}  // namespace

MeshTree::MeshTree(std::vector<dvec3> vertices, std::vector<std::uint32_t> triangles,
                   std::span<const std::uint64_t> codes)
    : vertices_(std::move(vertices)), triangles_(std::move(triangles)) {
  const auto count = static_cast<std::uint32_t>(triangles_.size() / 3);
  if (count == 0) return;
  Guide guide{std::vector<dvec3>(codes.empty() ? count : 0), codes, std::vector<std::uint32_t>(count)};
  double shortest = 1e300;
  for (std::uint32_t t = 0; t < count; ++t) {
    const dvec3 &a = vertices_[triangles_[3 * t]], &b = vertices_[triangles_[3 * t + 1]],
                &c = vertices_[triangles_[3 * t + 2]];
    if (codes.empty()) guide.centres[t] = (a + b + c) / 3.0;
    for (const dvec3& edge : {b - a, c - b, a - c})
      if (const double square = glm::dot(edge, edge); square > 0) shortest = std::min(shortest, square);
  }
  shortest = std::sqrt(shortest);
  double farthest = 0;
  for (const dvec3& v : vertices_)
    farthest = std::max({farthest, std::abs(v.x), std::abs(v.y), std::abs(v.z)});
  // Well above the rounding of coordinates, for triangles of any size.
  gap_ = std::clamp(1e-3 * shortest, std::min(1e-5, 1e-10 * farthest), 1e-5);
  std::vector<std::uint32_t>& order = guide.order;
  std::iota(order.begin(), order.end(), 0u);
  nodes_.reserve(count);
  build(0, count, guide, 0);
  if (!codes.empty()) {
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

namespace {
/// Returns the first triangle at which the highest differing bit of the codes changes; the middle if all
/// codes are equal. `begin`, `end`: triangles, two per code.
std::uint32_t split_by_codes(std::span<const std::uint64_t> codes, std::uint32_t begin, std::uint32_t end) {
  const std::uint64_t first = codes[begin / 2], differing = first ^ codes[(end - 1) / 2];
  if (differing == 0) return (begin + end) / 2;
  const std::uint64_t bit = std::bit_floor(differing);
  const auto* const found =
      std::partition_point(codes.data() + begin / 2, codes.data() + (end + 1) / 2,
                           [&](std::uint64_t code) { return (code & bit) == (first & bit); });
  return 2 * static_cast<std::uint32_t>(found - codes.data());
}
}  // namespace

/// Builds the nodes of triangles `begin` to `end` - 1. Returns the index of their root.
std::uint32_t MeshTree::build(std::uint32_t begin, std::uint32_t end, Guide& guide, int depth) {
  const auto index = static_cast<std::uint32_t>(nodes_.size());
  nodes_.push_back({dvec3(0), dvec3(0), begin, end - begin});
  if (end - begin <= k_leaf || depth == k_deepest - 2) {
    // Sorts in ascending order, so that a tree that is rebuilt from the sorted triangles has equal nodes.
    std::sort(guide.order.begin() + begin, guide.order.begin() + end);
    return index;
  }
  std::uint32_t middle = (begin + end) / 2;
  if (!guide.codes.empty())
    middle = split_by_codes(guide.codes, begin, end);
  else
    split(begin, middle, end, guide.centres, guide.order);
  build(begin, middle, guide, depth + 1);
  const std::uint32_t second = build(middle, end, guide, depth + 1);
  nodes_[index].first = second;
  nodes_[index].count = 0;
  return index;
}

/// Splits along the longest side of the box of centres.
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
  // Children come after their parents, so the loop runs backward.
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

std::size_t MeshTree::find_near(const dvec3& p, double reach, std::span<Facet> facets) const noexcept {
  std::size_t count = 0;
  for_triangles(
      [&](const Node& node) { return count <= facets.size() && square_to(node, p) <= reach * reach; },
      [&](std::uint32_t t) {
        Near near;
        if (count > facets.size() || !nearest_on(t, p, reach, near)) return;
        if (count < facets.size()) facets[count] = Facet(t, corners(t), near.normal);
        ++count;
      });
  return count;
}

bool MeshTree::is_near(const dvec3& p, double reach) const noexcept {
  bool is_any = false;
  for_triangles([&](const Node& node) { return !is_any && square_to(node, p) <= reach * reach; },
                [&](std::uint32_t t) {
                  Near near;
                  is_any = is_any || nearest_on(t, p, reach, near);
                });
  return is_any;
}

bool MeshTree::cast(const dvec3& a, const dvec3& b, bool is_front, bool is_back, FacetHit& hit,
                    int& visited) const noexcept {
  if (a == b) return false;
  const dvec3 motion = b - a;
  const BoxTest boxes(a, motion, 0, low(), high());
  const TriangleCrossing crossing(a, motion);
  double nearest = std::numeric_limits<double>::infinity();
  const auto meets = [&](const Node& node) {
    return boxes.meets(node.low, node.high, std::min(1.0, nearest));
  };
  for_triangles(meets, [&](std::uint32_t i) {
    const auto [p, q, r] = corners(i);
    double t = 0, direction_dot_normal = 0;
    ++visited;
    if (!crossing.crosses(p, q, r, t, direction_dot_normal) || t >= nearest) return;
    if (direction_dot_normal < 0 ? !is_front : !is_back) return;
    const dvec3 normal = glm::normalize(glm::cross(q - p, r - p));
    nearest = t;
    hit.t = t;
    hit.normal_world = direction_dot_normal < 0 ? normal : -normal;
    hit.side = side_of(direction_dot_normal >= 0);
    hit.triangle = i;
  });
  return nearest <= 1;
}

std::uint32_t MeshTree::nearest_connected(std::uint32_t triangle, const dvec3& p,
                                          int& visited) const noexcept {
  constexpr int k_max_steps = 16;
  constexpr double k_nearer = 1e-9;       // fraction of the distance; a smaller decrease does not count
  constexpr double k_coincident = 1e-10;  // relative to coordinates; corners within it coincide
  int remaining = k_max_connected;
  for (int step = 0; step < k_max_steps; ++step) {
    const auto [u, v, w] = corners(triangle);
    TriangleFeature feature;
    const dvec3 pivot = nearest_on_triangle(p, u, v, w, &feature);
    if (feature == TriangleFeature::face) break;
    double least = (1 - k_nearer) * glm::length(p - pivot);
    const double reach = k_coincident * (1 + glm::length(pivot));
    std::uint32_t nearer = triangle;
    const auto can_be_nearer = [&](const Node& node) {
      return remaining > 0 && square_to(node, pivot) <= reach * reach && square_to(node, p) < least * least;
    };
    for_triangles(can_be_nearer, [&](std::uint32_t other) {
      --remaining, ++visited;
      Near near;
      if (!nearest_on(other, pivot, reach, near)) return;
      const auto [a, b, c] = corners(other);
      if (const double distance = glm::length(p - nearest_on_triangle(p, a, b, c)); distance < least)
        least = distance, nearer = other;
    });
    if (nearer == triangle) break;
    triangle = nearer;
  }
  return triangle;
}

bool MeshTree::cast_ball(const dvec3& a, const dvec3& b, double radius, bool is_front, bool is_back,
                         FacetHit& hit, int& visited, double latest) const noexcept {
  if (a == b) return false;
  const dvec3 motion = b - a;
  const double length = glm::length(motion);
  const BoxTest boxes(a, motion, radius, low(), high());
  double nearest = std::numeric_limits<double>::infinity();
  // Largest distance from the start of the ball's centre at which the ball may meet a triangle, with slack
  // for rounding.
  const double farthest =
      (1 + 1e-9) * (radius + latest * length) + 1e-12 * glm::length(glm::max(glm::abs(a), glm::abs(b)));
  const auto meets = [&](const Node& node) {
    return square_to(node, a) <= farthest * farthest &&
           boxes.meets(node.low, node.high, std::min(latest, nearest));
  };
  for_triangles(meets, [&](std::uint32_t i) {
    const auto [p, q, r] = corners(i);
    const dvec3 across = glm::cross(q - p, r - p);
    if (!(glm::dot(across, across) > 0)) return;  // degenerate
    const bool is_before = glm::dot(across, a - p) >= 0;
    if (is_before ? !is_front : !is_back) return;
    ++visited;
    // A triangle is convex, so the distance to it is a convex function along the motion. Newton steps that
    // start before the first contact never pass that contact. If the distance increases, there is no contact.
    double t = 0;
    for (int k = 0; k < k_max_newton; ++k) {
      const dvec3 at = a + t * motion, off = at - nearest_on_triangle(at, p, q, r);
      const double distance = glm::length(off), approach = -glm::dot(off, motion);
      if (!(approach > 0)) return;  // passes by, or moves away
      const double remaining = distance - radius;
      if (remaining <= k_near * length || k + 1 == k_max_newton) {
        if (t >= nearest) return;
        nearest = t;
        hit.t = t;
        hit.normal_world = distance > 0 ? off / distance : glm::normalize(-motion);
        hit.side = side_of(!is_before);
        hit.triangle = i;
        return;
      }
      t += remaining * distance / approach;
      if (!(t <= latest && t < nearest)) return;
    }
  });
  return nearest <= 1;
}

std::size_t MeshTree::bytes() const noexcept {
  return vertices_.size() * sizeof(dvec3) + triangles_.size() * sizeof(std::uint32_t) +
         nodes_.size() * sizeof(Node);
}

}  // namespace trephine::haptics
