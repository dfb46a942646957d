#include "haptics/tool/point_shell.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <glm/geometric.hpp>
#include <optional>
#include <string>
#include <tuple>
#include <unordered_map>

#include "volume/base/mix_hash.h"
#include "volume/base/morton.h"
#include "volume/base/text.h"
#include "volume/surface/lathe.h"

namespace trephine::haptics {

using glm::dvec3;

namespace {

constexpr double k_farthest = 300, k_finest = 0.02;  // mm

constexpr double k_sharp_cosine = 0.94;  // faces that meet at more than 20 degrees form a sharp edge
// Shares of the spacing. Every point of the surface has a candidate within 0.24, and every candidate has a
// sample within 0.75.
constexpr double k_candidate_step = 0.33, k_apart = 0.75, k_edge_apart = 0.5;

struct Candidate {
  dvec3 position, outward;
  std::uint64_t order;  // candidates with a smaller value are taken first
  double area = 0;      // mm2 of its triangle
};

std::string mm(double value) { return rounded_text(value) + " mm"; }
std::string point_text(const dvec3& p) {
  char text[96];
  std::snprintf(text, sizeof text, "(%.6g, %.6g, %.6g) mm", p.x, p.y, p.z);
  return text;
}

/// Returns true if k_max_points may suffice for a surface of `area` mm2. This is a coarse test before
/// sampling: samples on faces are at least 0.75 of the spacing apart, about 1.2 per square of the spacing.
/// After sampling, their number is checked exactly.
bool fits_point_limit(double area, double spacing) {
  return area <= 2 * static_cast<double>(PointShell::k_max_points) * spacing * spacing;
}
Error too_many_points(double spacing) {
  return {.what = "the tool needs too many points",
          .where = "spacing",
          .found = mm(spacing),
          .expected = "at most " + std::to_string(PointShell::k_max_points) + " points",
          .remedy = "use a larger spacing, or a smaller tool"};
}

/// Accepted samples in cubic cells, to find samples that are near a candidate.
class CellGrid {
 public:
  explicit CellGrid(double cell) : cell_(cell) {}
  /// Returns true if a sample is nearer than `distance`, at most one cell.
  bool has_within(const dvec3& p, double distance) const {
    const glm::ivec3 c = cell_of(p);
    for (int z = -1; z <= 1; ++z)
      for (int y = -1; y <= 1; ++y)
        for (int x = -1; x <= 1; ++x)
          if (const auto found = cells_.find(key(c + glm::ivec3(x, y, z))); found != cells_.end())
            for (const auto& [q, number] : found->second)
              if (glm::dot(p - q, p - q) < distance * distance) return true;
    return false;
  }
  /// Returns the number of the nearest sample within `distance`, at most one cell.
  std::optional<std::size_t> nearest(const dvec3& p, double distance) const {
    const glm::ivec3 c = cell_of(p);
    std::optional<std::size_t> best;
    double least = distance * distance;
    for (int z = -1; z <= 1; ++z)
      for (int y = -1; y <= 1; ++y)
        for (int x = -1; x <= 1; ++x)
          if (const auto found = cells_.find(key(c + glm::ivec3(x, y, z))); found != cells_.end())
            for (const auto& [q, number] : found->second)
              if (const double square = glm::dot(p - q, p - q); square < least) least = square, best = number;
    return best;
  }
  void add(const dvec3& p) { cells_[key(cell_of(p))].emplace_back(p, count_++); }

 private:
  glm::ivec3 cell_of(const dvec3& p) const { return glm::ivec3(glm::floor(p / cell_)); }
  static std::uint64_t key(const glm::ivec3& c) {
    const auto part = [](int i) { return static_cast<std::uint64_t>(i + (1 << 20)) & 0x1fffff; };
    return part(c.x) | part(c.y) << 21 | part(c.z) << 42;
  }
  double cell_;
  std::size_t count_ = 0;
  std::unordered_map<std::uint64_t, std::vector<std::pair<dvec3, std::size_t>>> cells_;
};

/// An edge of one triangle, with the smaller vertex index first.
struct Edge {
  std::uint32_t a, b, triangle;
  bool is_reversed;  ///< the triangle leads from b to a
};

class Sampler {
 public:
  Sampler(std::span<const dvec3> vertices, std::span<const std::uint32_t> triangles, double spacing,
          PointShell::Areas areas)
      : vertices_(vertices),
        triangles_(triangles),
        spacing_(spacing),
        has_areas_(areas == PointShell::Areas::computed) {}

  Status run(std::vector<PointShell::Point>& points) {
    if (Status error = find_edges()) return error;
    CellGrid grid(spacing_);
    take(corner_candidates(), 0.05 * spacing_, grid, points);
    take(edge_candidates(), k_edge_apart * spacing_, grid, points);
    if (Status error = take_faces(grid, points)) return error;
    return std::nullopt;
  }

 private:
  dvec3 corner(std::uint32_t triangle, std::uint32_t k) const {
    return vertices_[triangles_[3 * triangle + k]];
  }
  dvec3 area_vector(std::uint32_t t) const {
    return 0.5 * glm::cross(corner(t, 1) - corner(t, 0), corner(t, 2) - corner(t, 0));
  }
  static dvec3 unit(const dvec3& v) {
    const double length = glm::length(v);
    return length > 0 ? v / length : dvec3(0);
  }
  std::uint64_t order_of(std::uint64_t number) const {
    MixHash hash;
    hash.add(number);
    hash.add(number ^ 0x5555);
    return hash.value();
  }

  /// Finds the sharp edges. Error if an edge does not belong to two triangles.
  Status find_edges() {
    std::vector<Edge> all;
    all.reserve(triangles_.size());
    for (std::uint32_t t = 0; t < triangles_.size() / 3; ++t)
      for (std::uint32_t k = 0; k < 3; ++k) {
        const std::uint32_t a = triangles_[3 * t + k], b = triangles_[3 * t + (k + 1) % 3];
        all.push_back({std::min(a, b), std::max(a, b), t, a > b});
      }
    std::sort(all.begin(), all.end(), [](const Edge& x, const Edge& y) {
      return std::tuple(x.a, x.b, x.triangle) < std::tuple(y.a, y.b, y.triangle);
    });
    for (std::size_t i = 0; i < all.size(); i += 2) {
      const Edge& e = all[i];
      const bool is_pair = i + 1 < all.size() && all[i + 1].a == e.a && all[i + 1].b == e.b &&
                           all[i + 1].is_reversed != e.is_reversed &&
                           (i + 2 >= all.size() || all[i + 2].a != e.a || all[i + 2].b != e.b);
      if (!is_pair)
        return Error{.what = "the mesh of the tool is not closed",
                     .where = "edge from " + point_text(vertices_[e.a]) + " to " + point_text(vertices_[e.b]),
                     .expected = "each edge in two triangles, of opposite directions",
                     .remedy = "close the mesh, and give all triangles one orientation"};
      const dvec3 u = unit(area_vector(e.triangle)), v = unit(area_vector(all[i + 1].triangle));
      if (glm::dot(u, v) < k_sharp_cosine) sharp_.push_back({e.a, e.b, unit(u + v)});
    }
    return std::nullopt;
  }

  std::vector<Candidate> corner_candidates() const {
    std::vector<int> count(vertices_.size(), 0);
    std::vector<dvec3> outward(vertices_.size(), dvec3(0));
    for (const Sharp& edge : sharp_)
      for (const std::uint32_t v : {edge.a, edge.b}) ++count[v], outward[v] += edge.outward;
    std::vector<Candidate> all;
    for (std::size_t v = 0; v < vertices_.size(); ++v)
      if (count[v] > 2) all.push_back({vertices_[v], unit(outward[v]), order_of(v)});
    return all;
  }
  std::vector<Candidate> edge_candidates() const {
    std::vector<Candidate> all;
    for (const Sharp& edge : sharp_) {
      const dvec3 a = vertices_[edge.a], b = vertices_[edge.b];
      const int steps = std::max(1, static_cast<int>(std::ceil(glm::length(b - a) / (0.25 * spacing_))));
      for (int i = 0; i <= steps; ++i)
        all.push_back({a + (static_cast<double>(i) / steps) * (b - a), edge.outward, order_of(all.size())});
    }
    return all;
  }
  Status take_faces(CellGrid& grid, std::vector<PointShell::Point>& points) const {
    double area = 0;
    for (std::uint32_t t = 0; t < triangles_.size() / 3; ++t) area += glm::length(area_vector(t));
    if (!fits_point_limit(area, spacing_)) return too_many_points(spacing_);
    std::vector<Candidate> all;
    const double step = k_candidate_step * spacing_;
    for (std::uint32_t t = 0; t < triangles_.size() / 3; ++t) {
      // Candidates lie in rows parallel to the longest side, which leads from a to b.
      std::uint32_t first = 0;
      for (std::uint32_t k = 1; k < 3; ++k)
        if (glm::length(corner(t, (k + 1) % 3) - corner(t, k)) >
            glm::length(corner(t, (first + 1) % 3) - corner(t, first)))
          first = k;
      const dvec3 a = corner(t, first), b = corner(t, (first + 1) % 3), c = corner(t, (first + 2) % 3);
      const double longest = glm::length(b - a);
      if (!(longest > 0)) continue;
      const dvec3 normal = area_vector(t), outward = unit(normal);
      const int rows = std::max(1, static_cast<int>(std::ceil(2 * glm::length(normal) / longest / step)));
      const std::size_t begin = all.size();
      double total = 0;
      for (int r = 0; r <= rows; ++r) {
        const double share = static_cast<double>(r) / rows, weight = r == 0 || r == rows ? 0.5 : 1;
        const dvec3 left = a + share * (c - a), right = b + share * (c - b);
        const int steps = std::max(1, static_cast<int>(std::ceil((1 - share) * longest / step)));
        for (int i = 0; i <= steps; ++i) {
          // The area that a candidate stands for, by the trapezoidal rule, in units that are scaled below.
          const double part = weight * (1 - share) / steps * (i == 0 || i == steps ? 0.5 : 1);
          total += part;
          all.push_back({left + (static_cast<double>(i) / steps) * (right - left), outward,
                         order_of(all.size()), part});
        }
      }
      for (std::size_t i = begin; i < all.size(); ++i) all[i].area *= glm::length(normal) / total;
    }
    take(all, k_apart * spacing_, grid, points);
    for (const Candidate& candidate : has_areas_ ? all : std::vector<Candidate>())
      if (const auto nearest = grid.nearest(candidate.position, spacing_))
        points[*nearest].area += candidate.area;
    return points.size() > PointShell::k_max_points ? Status(too_many_points(spacing_)) : std::nullopt;
  }
  static void take(std::vector<Candidate> all, double least_distance, CellGrid& grid,
                   std::vector<PointShell::Point>& points) {
    std::sort(all.begin(), all.end(), [](const Candidate& a, const Candidate& b) {
      return std::tuple(a.order, a.position.x, a.position.y, a.position.z) <
             std::tuple(b.order, b.position.x, b.position.y, b.position.z);
    });
    for (const Candidate& candidate : all) {
      if (grid.has_within(candidate.position, least_distance)) continue;
      grid.add(candidate.position);
      points.push_back({candidate.position, -candidate.outward, 0});
    }
  }

  struct Sharp {
    std::uint32_t a, b;
    dvec3 outward;
  };
  std::span<const dvec3> vertices_;
  std::span<const std::uint32_t> triangles_;
  double spacing_;
  bool has_areas_;
  std::vector<Sharp> sharp_;
};

/// Integrates over tetrahedra from the origin to each triangle (Tonon 2004).
PointShell::Solid solid_of(std::span<const dvec3> vertices, std::span<const std::uint32_t> triangles) {
  PointShell::Solid solid;
  dvec3 first(0);
  glm::dmat3 second(0);
  for (std::size_t t = 0; t + 2 < triangles.size(); t += 3) {
    const dvec3 &a = vertices[triangles[t]], &b = vertices[triangles[t + 1]], &c = vertices[triangles[t + 2]];
    const double six = glm::dot(a, glm::cross(b, c));
    const dvec3 sum = a + b + c;
    solid.volume += six / 6;
    first += (six / 24) * sum;
    second += (six / 120) * (glm::outerProduct(a, a) + glm::outerProduct(b, b) + glm::outerProduct(c, c) +
                             glm::outerProduct(sum, sum));
  }
  if (!(solid.volume > 0)) return solid;
  solid.centre = first / solid.volume;
  second -= solid.volume * glm::outerProduct(solid.centre, solid.centre);
  const double trace = second[0][0] + second[1][1] + second[2][2];
  solid.inertia = glm::dmat3(trace) - second;
  return solid;
}

}  // namespace

void PointShell::build_tree() {
  dvec3 low(1e300), high(-1e300);
  for (const Point& p : points_) low = glm::min(low, p.position), high = glm::max(high, p.position);
  const double side = std::max({high.x - low.x, high.y - low.y, high.z - low.z, 1e-9});
  constexpr double k_cells = (1 << 20) - 1;
  std::vector<std::pair<std::uint64_t, std::uint32_t>> order;
  for (std::uint32_t i = 0; i < points_.size(); ++i)
    order.emplace_back(volume::morton_code(glm::ivec3((points_[i].position - low) / side * k_cells)), i);
  std::sort(order.begin(), order.end());
  std::vector<Point> sorted;
  sorted.reserve(points_.size());
  for (const auto& [code, i] : order) sorted.push_back(points_[i]);
  points_ = std::move(sorted);

  const auto bound = [&](Node& node) {
    dvec3 a(1e300), b(-1e300);
    for (std::uint32_t i = node.begin; i < node.end; ++i)
      a = glm::min(a, points_[i].position), b = glm::max(b, points_[i].position);
    node.centre = 0.5 * (a + b);
    for (std::uint32_t i = node.begin; i < node.end; ++i)
      node.radius = std::max(node.radius, glm::length(points_[i].position - node.centre));
    node.radius *= 1 + 1e-12;
  };
  const auto count = static_cast<std::uint32_t>(points_.size());
  for (std::uint32_t i = 0; i < count; i += k_leaf) {
    Node leaf;
    leaf.begin = i, leaf.end = std::min<std::uint32_t>(count, i + k_leaf);
    bound(leaf);
    nodes_.push_back(leaf);
  }
  for (std::uint32_t begin = 0, end = static_cast<std::uint32_t>(nodes_.size()); end - begin > 1;) {
    for (std::uint32_t i = begin; i < end; i += k_children) {
      Node parent;
      parent.first_child = i, parent.children = std::min<std::uint32_t>(end - i, k_children);
      parent.begin = nodes_[i].begin, parent.end = nodes_[i + parent.children - 1].end;
      bound(parent);
      nodes_.push_back(parent);
    }
    begin = end, end = static_cast<std::uint32_t>(nodes_.size());
  }
  MixHash hash;
  for (const Point& p : points_) {
    arm_ = std::max(arm_, glm::length(p.position));
    for (int a = 0; a < 3; ++a) hash.add(p.position[a]), hash.add(p.inward[a]);
  }
  hash_ = hash.value();
}

Result<SharedShell> PointShell::of_mesh(std::span<const dvec3> vertices,
                                        std::span<const std::uint32_t> triangles, double spacing,
                                        Areas areas) {
  if (!(spacing >= k_finest))
    return Error{.what = "the spacing of the tool's points is too small",
                 .where = "spacing",
                 .found = mm(spacing),
                 .expected = mm(k_finest) + " or more",
                 .remedy = "use half a voxel of the scan"};
  if (triangles.size() < 12)
    return Error{.what = "the mesh of the tool has too few triangles",
                 .where = "tool",
                 .found = std::to_string(triangles.size() / 3),
                 .expected = "a closed surface of four triangles or more"};
  for (const dvec3& v : vertices)
    if (!(glm::length(v) <= k_farthest))
      return Error{.what = "the tool is too far from the haptic interface point",
                   .where = "vertex",
                   .found = point_text(v),
                   .expected = "within " + mm(k_farthest),
                   .remedy = "move the origin of the mesh to the tip of the tool"};
  std::shared_ptr<PointShell> shell(new PointShell);
  shell->spacing_ = spacing;
  if (Status error = Sampler(vertices, triangles, spacing, areas).run(shell->points_)) return *error;
  shell->solid_ = solid_of(vertices, triangles);
  if (!(shell->solid_.volume > 0))
    return Error{.what = "the mesh of the tool encloses no volume",
                 .where = "tool",
                 .found = rounded_text(shell->solid_.volume) + " mm3",
                 .expected = "triangles counter-clockwise as viewed from outside",
                 .remedy = "reverse the triangles"};
  shell->build_tree();
  return SharedShell(std::move(shell));
}

Status PointShell::check(const ToolProfile& profile) {
  const auto invalid = [](const char* where, const std::string& found, const char* expected) {
    return Error{.what = "the profile of the tool is invalid",
                 .where = where,
                 .found = found,
                 .expected = expected,
                 .remedy = "list the rings from the tip toward the hand; use a spacing of 0.02 mm or more"};
  };
  const std::vector<ToolProfile::Ring>& rings = profile.rings;
  if (rings.size() < 2 || rings.size() > ToolProfile::k_max_rings)
    return invalid("profile", std::to_string(rings.size()) + " rings", "2 to 256 rings");
  double area = 0;
  for (std::size_t i = 0; i < rings.size(); ++i) {
    if (!(std::abs(rings[i].along) <= k_farthest && rings[i].radius <= k_farthest))
      return invalid("profile", "a ring at " + mm(rings[i].along),
                     "within 300 mm of the haptic interface point");
    if (!(rings[i].radius > 0))
      return invalid("profile", "a radius of " + mm(rings[i].radius), "more than 0");
    if (i > 0 && !(rings[i].along >= rings[i - 1].along))
      return invalid("profile", "a ring at " + mm(rings[i].along), "positions in increasing order");
    if (i == 0) continue;
    const glm::dvec3 side(rings[i].along - rings[i - 1].along, rings[i].radius - rings[i - 1].radius, 0);
    area += 3.1416 * (rings[i].radius + rings[i - 1].radius) * glm::length(side);
  }
  if (!(rings.back().along > rings.front().along)) return invalid("profile", "no length", "rings apart");
  if (!(profile.spacing >= k_finest)) return invalid("spacing", mm(profile.spacing), "0.02 mm or more");
  if (!fits_point_limit(area, profile.spacing)) return too_many_points(profile.spacing);
  return std::nullopt;
}

Result<SharedShell> PointShell::of_profile(const ToolProfile& profile, Areas areas) {
  if (Status error = check(profile)) return *error;
  double widest = 0;
  std::vector<volume::TurnedRing> rings;
  for (const ToolProfile::Ring& ring : profile.rings) {
    rings.push_back({ring.along, ring.radius});
    widest = std::max(widest, ring.radius);
  }
  // At least 24 facets, so that none of their edges counts as sharp.
  const int facets =
      static_cast<int>(std::clamp(std::ceil(2 * 3.1416 * widest / profile.spacing), 24.0, 512.0));
  const volume::TurnedSolid solid =
      volume::turned_solid(rings.front().along, rings, rings.back().along, facets);
  return of_mesh(solid.vertices, solid.triangles, profile.spacing, areas);
}

}  // namespace trephine::haptics
