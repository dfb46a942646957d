#include "haptics/mesh/surface_line.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <map>
#include <queue>

#include "haptics/mesh/mesh_tree.h"

namespace trephine::haptics {

using glm::dvec3;

namespace {
constexpr std::size_t k_speck = 100;  // triangles; a part with fewer counts as noise
}  // namespace

Surface::Surface(std::vector<dvec3> vertices, std::vector<std::uint32_t> triangles) {
  std::map<std::array<double, 3>, std::uint32_t> known;
  std::vector<std::uint32_t> merged;
  merged.reserve(vertices.size());
  for (const dvec3& v : vertices) {
    const auto [at, is_new] =
        known.emplace(std::array{v.x, v.y, v.z}, static_cast<std::uint32_t>(vertices_.size()));
    if (is_new) vertices_.push_back(v);
    merged.push_back(at->second);
  }
  for (std::size_t t = 0; t + 2 < triangles.size(); t += 3) {
    const std::array<std::uint32_t, 3> c{merged[triangles[t]], merged[triangles[t + 1]],
                                         merged[triangles[t + 2]]};
    if (c[0] == c[1] || c[1] == c[2] || c[2] == c[0]) continue;
    triangles_.insert(triangles_.end(), c.begin(), c.end());
  }
  first_.assign(vertices_.size() + 1, 0);
  for (const std::uint32_t v : triangles_) ++first_[v + 1];
  for (std::size_t i = 0; i < vertices_.size(); ++i) first_[i + 1] += first_[i];
  around_.resize(triangles_.size());
  std::vector<std::uint32_t> next(first_.begin(), first_.end() - 1);
  for (std::uint32_t i = 0; i < triangles_.size(); ++i) around_[next[triangles_[i]]++] = i / 3;
}

bool Surface::nearest(const dvec3& p, Point& place) const {
  double least = std::numeric_limits<double>::infinity();
  for (std::uint32_t t = 0; 3 * t < triangles_.size(); ++t) {
    const dvec3 &a = vertices_[triangles_[3 * t]], &b = vertices_[triangles_[3 * t + 1]],
                &c = vertices_[triangles_[3 * t + 2]];
    // Skips a triangle if its first corner is farther away than the nearest point so far plus the triangle's
    // size.
    const double reach = std::sqrt(least) + std::max(glm::length(b - a), glm::length(c - a));
    if (glm::length(p - a) > reach) continue;
    const dvec3 at = nearest_on_triangle(p, a, b, c);
    const double squared = glm::dot(p - at, p - at);
    if (squared < least) least = squared, place = {t, at};
  }
  return std::isfinite(least);
}

std::vector<Surface::Point> Surface::nearest_on_one_part(std::span<const dvec3> points) const {
  // Joins the corners of each triangle, which gives the connected parts.
  std::vector<std::uint32_t> part(vertices_.size());
  for (std::uint32_t v = 0; v < part.size(); ++v) part[v] = v;
  const auto root = [&part](std::uint32_t v) {
    while (part[v] != v) v = part[v] = part[part[v]];
    return v;
  };
  for (std::size_t t = 0; t + 2 < triangles_.size(); t += 3)
    for (std::size_t k = 1; k < 3; ++k) part[root(triangles_[t + k])] = root(triangles_[t]);
  struct Part {
    std::size_t triangles = 0;
    std::vector<Point> places;
    std::vector<double> squared;
  };
  std::map<std::uint32_t, Part> parts;
  for (std::size_t t = 0; t + 2 < triangles_.size(); t += 3) ++parts[root(triangles_[t])].triangles;
  if (std::any_of(parts.begin(), parts.end(),
                  [](const auto& one) { return one.second.triangles >= k_speck; }))
    std::erase_if(parts, [](const auto& one) { return one.second.triangles < k_speck; });
  for (auto& [name, one] : parts) {
    one.places.resize(points.size());
    one.squared.assign(points.size(), std::numeric_limits<double>::infinity());
  }
  for (std::uint32_t t = 0; 3 * t < triangles_.size(); ++t) {
    const auto found = parts.find(root(triangles_[3 * t]));
    if (found == parts.end()) continue;
    const dvec3 &a = vertices_[triangles_[3 * t]], &b = vertices_[triangles_[3 * t + 1]],
                &c = vertices_[triangles_[3 * t + 2]];
    const double size = std::max(glm::length(b - a), glm::length(c - a));
    for (std::size_t i = 0; i < points.size(); ++i) {
      const double reach = std::sqrt(found->second.squared[i]) + size;
      if (glm::dot(points[i] - a, points[i] - a) > reach * reach) continue;
      const dvec3 at = nearest_on_triangle(points[i], a, b, c);
      const double squared = glm::dot(points[i] - at, points[i] - at);
      if (squared < found->second.squared[i])
        found->second.squared[i] = squared, found->second.places[i] = {t, at};
    }
  }
  const Part* best = nullptr;
  double least = std::numeric_limits<double>::infinity();
  for (const auto& [name, one] : parts) {
    double sum = 0;
    for (const double squared : one.squared) sum += std::sqrt(squared);
    if (sum < least) least = sum, best = &one;
  }
  return best != nullptr ? best->places : std::vector<Point>();
}

double length_of(const std::vector<dvec3>& line) noexcept {
  double sum = 0;
  for (std::size_t i = 1; i < line.size(); ++i) sum += glm::length(line[i] - line[i - 1]);
  return sum;
}

/// Finds a line by its nodes: on vertices, on edges, and within triangles at the ends.
class LineFinder {
 public:
  explicit LineFinder(const Surface& surface) : s_(surface) {}

  std::vector<dvec3> find(const Surface::Point& from, const Surface::Point& to) {
    if (!walk_edges(from, to)) return {};
    double length = length_of(points());
    int settled_rounds = 0;
    for (int round = 0; round < k_max_rounds && settled_rounds < 20; ++round) {
      pull_ = settled_rounds < 10 && round < k_max_rounds - 100 ? 1.85 : 1;
      for (std::size_t i = 1; i + 1 < nodes_.size(); ++i) straighten(i);
      tidy();
      const double now = length_of(points());
      settled_rounds = std::abs(now - length) < 1e-8 * length ? settled_rounds + 1 : 0;
      length = now;
    }
    return points();
  }

 private:
  static constexpr int k_max_rounds = 3000;
  static constexpr std::uint32_t k_none = 0xffffffffu;

  struct Node {
    /// Ends of the edge of a node on an edge. A node on a vertex has only `a`, a node in a triangle has
    /// neither.
    std::uint32_t a = k_none, b = k_none;
    std::uint32_t triangle = k_none;  ///< triangle of a node in a triangle
    dvec3 at{0.0};
    bool is_vertex() const { return a != k_none && b == k_none; }
    bool is_edge() const { return b != k_none; }
  };

  const dvec3& vertex(std::uint32_t v) const { return s_.vertices_[v]; }
  const std::uint32_t* corners(std::uint32_t t) const { return s_.triangles_.data() + 3 * std::size_t{t}; }
  bool has(std::uint32_t t, std::uint32_t v) const {
    const std::uint32_t* c = corners(t);
    return c[0] == v || c[1] == v || c[2] == v;
  }
  /// Returns true if a node is on a triangle.
  bool is_on(const Node& n, std::uint32_t t) const {
    if (n.triangle != k_none) return n.triangle == t;
    return has(t, n.a) && (n.b == k_none || has(t, n.b));
  }
  std::vector<dvec3> points() const {
    std::vector<dvec3> line;
    for (const Node& n : nodes_) line.push_back(n.at);
    return line;
  }

  /// Sets the nodes to the shortest path along edges, from the corners of one triangle to those of the other
  /// (Dijkstra). Returns false if the triangles are not connected.
  bool walk_edges(const Surface::Point& from, const Surface::Point& to) {
    nodes_.clear();
    if (from.triangle == to.triangle) {
      nodes_ = {{k_none, k_none, from.triangle, from.at}, {k_none, k_none, to.triangle, to.at}};
      return true;
    }
    std::vector<double> distance(s_.vertices_.size(), std::numeric_limits<double>::infinity());
    std::vector<std::uint32_t> parent(s_.vertices_.size(), k_none);
    using Item = std::pair<double, std::uint32_t>;
    std::priority_queue<Item, std::vector<Item>, std::greater<>> queue;
    for (int k = 0; k < 3; ++k) {
      const std::uint32_t v = corners(from.triangle)[k];
      distance[v] = glm::length(vertex(v) - from.at);
      queue.push({distance[v], v});
    }
    double least = std::numeric_limits<double>::infinity();
    std::uint32_t last = k_none;
    while (!queue.empty()) {
      const auto [so_far, v] = queue.top();
      queue.pop();
      if (so_far > distance[v]) continue;
      if (so_far >= least) break;
      if (has(to.triangle, v) && so_far + glm::length(vertex(v) - to.at) < least)
        least = so_far + glm::length(vertex(v) - to.at), last = v;
      for (std::uint32_t i = s_.first_[v]; i < s_.first_[v + 1]; ++i)
        for (int k = 0; k < 3; ++k) {
          const std::uint32_t w = corners(s_.around_[i])[k];
          const double longer = so_far + glm::length(vertex(w) - vertex(v));
          if (longer < distance[w]) distance[w] = longer, parent[w] = v, queue.push({longer, w});
        }
    }
    if (last == k_none) return false;
    nodes_.push_back({k_none, k_none, to.triangle, to.at});
    for (std::uint32_t v = last; v != k_none; v = parent[v]) nodes_.push_back({v, k_none, k_none, vertex(v)});
    nodes_.push_back({k_none, k_none, from.triangle, from.at});
    std::reverse(nodes_.begin(), nodes_.end());
    return true;
  }

  void straighten(std::size_t i) {
    if (nodes_[i].is_edge())
      slide(i);
    else if (nodes_[i].is_vertex())
      leave_vertex(i);
  }

  /// Moves a node on an edge to where the line is straight in the unfolded triangles.
  void slide(std::size_t i) {
    Node& n = nodes_[i];
    const dvec3 &a = vertex(n.a), &b = vertex(n.b), along = b - a;
    const double length = glm::length(along);
    const auto flat = [&](const dvec3& p, double& x, double& y) {
      x = glm::dot(p - a, along) / length;
      y = glm::length(p - a - x / length * along);
    };
    double x0, y0, x1, y1;
    flat(nodes_[i - 1].at, x0, y0), flat(nodes_[i + 1].at, x1, y1);
    const double best = y0 + y1 > 0 ? (x0 * y1 + x1 * y0) / (y0 + y1) / length : 0.5 * (x0 + x1) / length;
    // Moves beyond the straight line by the factor `pull_`, for faster convergence (successive
    // over-relaxation).
    const double now = glm::length(n.at - a) / length, t = now + pull_ * (best - now);
    constexpr double k_near = 1e-7;
    if (t <= k_near)
      n = {n.a, k_none, k_none, a};
    else if (t >= 1 - k_near)
      n = {n.b, k_none, k_none, b};
    else
      n.at = a + t * along;
  }

  /// Replaces a node on a vertex by nodes on the edges of one side, if the angle around the vertex on that
  /// side is below 180 degrees.
  void leave_vertex(std::size_t i) {
    const std::uint32_t v = nodes_[i].a;
    // Walks the fan around the vertex from each triangle with the previous node, in both directions.
    std::vector<Node> best;
    double shortest =
        glm::length(nodes_[i].at - nodes_[i - 1].at) + glm::length(nodes_[i + 1].at - nodes_[i].at);
    const double before = shortest;
    for (std::uint32_t k = s_.first_[v]; k < s_.first_[v + 1]; ++k) {
      const std::uint32_t start = s_.around_[k];
      if (!is_on(nodes_[i - 1], start)) continue;
      for (const bool is_forward : {true, false}) {
        std::vector<Node> side;
        const double length = path_around(i, v, start, is_forward, side);
        if (length < shortest - 1e-12) shortest = length, best = side;
      }
    }
    if (shortest >= before - 1e-12) return;
    nodes_.erase(nodes_.begin() + static_cast<std::ptrdiff_t>(i));
    nodes_.insert(nodes_.begin() + static_cast<std::ptrdiff_t>(i), best.begin(), best.end());
  }

  /// Finds a line from the previous to the next node that passes vertex v on one side, by unfolding the
  /// triangles of that side. Sets `side` to the nodes at which the line crosses the edges. Returns the length
  /// of the line, or infinity if there is no such line.
  double path_around(std::size_t i, std::uint32_t v, std::uint32_t start, bool is_forward,
                     std::vector<Node>& side) const {
    constexpr double k_endless = std::numeric_limits<double>::infinity();
    const Node &from = nodes_[i - 1], &to = nodes_[i + 1];
    const dvec3& middle = vertex(v);
    // The unfolded plane has the vertex at its origin and `from` on its first axis. A direction in the plane
    // is a cosine and a sine, and each triangle turns it by its angle. The total angle is below 180 degrees
    // as long as the sine is above 0.
    struct Direction {
      double cosine = 1, sine = 0;
      bool turn(const dvec3& a, const dvec3& b) {
        const double c = glm::dot(a, b), s = glm::length(glm::cross(a, b)), size = std::sqrt(c * c + s * s);
        if (!(size > 0)) return false;
        *this = {(cosine * c - sine * s) / size, (sine * c + cosine * s) / size};
        return true;
      }
    };
    std::vector<std::pair<std::uint32_t, Direction>> crossed;
    Direction direction;
    std::uint32_t t = start;
    const dvec3* last = &from.at;
    for (int steps = 0;; ++steps) {
      if (is_on(to, t)) {
        if (!direction.turn(*last - middle, to.at - middle)) return k_endless;
        break;
      }
      // The line leaves this triangle through the edge (v, w).
      const std::uint32_t* c = corners(t);
      const int k = c[0] == v ? 0 : c[1] == v ? 1 : 2;
      const std::uint32_t w = is_forward ? c[(k + 2) % 3] : c[(k + 1) % 3];
      if (!direction.turn(*last - middle, vertex(w) - middle)) return k_endless;
      if (direction.sine < 0 || (direction.sine == 0 && direction.cosine < 0)) return k_endless;
      crossed.push_back({w, direction});
      last = &vertex(w);
      std::uint32_t next = k_none;
      for (std::uint32_t n = s_.first_[v]; n < s_.first_[v + 1]; ++n)
        if (s_.around_[n] != t && has(s_.around_[n], w)) next = s_.around_[n];
      if (next == k_none || steps == 1000) return k_endless;
      t = next;
    }
    if (!(direction.sine > 1e-9)) return k_endless;
    const double r0 = glm::length(from.at - middle), r1 = glm::length(to.at - middle);
    if (!(r0 > 1e-12 && r1 > 1e-12)) return k_endless;
    // Computes the distance from the vertex at which the straight line crosses each edge. If a crossing is
    // beyond the end of its edge, all distances are scaled by one factor: a line that passes nearer to the
    // vertex is also shorter than the line through the vertex.
    std::vector<double> crossings;
    double scale = 1;
    for (const auto& [w, turned] : crossed) {
      const double rest = direction.sine * turned.cosine - direction.cosine * turned.sine;
      const double denominator = r0 * turned.sine + r1 * rest;
      const double r = denominator > 0 ? r0 * r1 * direction.sine / denominator : 0;
      if (!(r > 0)) return k_endless;
      crossings.push_back(r);
      scale = std::min(scale, 0.999 * glm::length(vertex(w) - middle) / r);
    }
    double length = 0;
    dvec3 at = from.at;
    for (std::size_t k = 0; k < crossed.size(); ++k) {
      const std::uint32_t w = crossed[k].first;
      const dvec3 edge = vertex(w) - middle;
      const Node node{v, w, k_none, middle + scale * crossings[k] / glm::length(edge) * edge};
      length += glm::length(node.at - at);
      at = node.at;
      side.push_back(node);
    }
    return length + glm::length(to.at - at);
  }

  /// Merges coincident nodes, and removes nodes that the line does not need.
  void tidy() {
    for (std::size_t i = 1; i + 1 < nodes_.size();) {
      const bool is_same = glm::length(nodes_[i].at - nodes_[i + 1].at) < 1e-9 ||
                           glm::length(nodes_[i].at - nodes_[i - 1].at) < 1e-9;
      bool is_needless = is_same;
      // Both neighbours are on one triangle: the line goes straight across it.
      if (!is_needless) is_needless = share_triangle(nodes_[i - 1], nodes_[i + 1]);
      if (is_needless)
        nodes_.erase(nodes_.begin() + static_cast<std::ptrdiff_t>(i));
      else
        ++i;
    }
  }
  bool share_triangle(const Node& a, const Node& b) const {
    const auto any = [&](const Node& n, const auto& use) {
      if (n.triangle != k_none) return use(n.triangle);
      for (std::uint32_t i = s_.first_[n.a]; i < s_.first_[n.a + 1]; ++i)
        if (is_on(n, s_.around_[i]) && use(s_.around_[i])) return true;
      return false;
    };
    return any(a, [&](std::uint32_t t) { return is_on(b, t); });
  }

  const Surface& s_;
  std::vector<Node> nodes_;
  double pull_ = 1;  ///< factor of over-relaxation
};

std::vector<dvec3> surface_line(const Surface& surface, const Surface::Point& from,
                                const Surface::Point& to) {
  return LineFinder(surface).find(from, to);
}

std::vector<dvec3> taut_line(const std::vector<dvec3>& line,
                             const std::function<Inside(const dvec3&)>& inside) {
  if (line.size() < 2) return line;
  // Places nodes at equal distances along the line, so that each node can move off the surface.
  const double surface_length = length_of(line);
  const auto steps = static_cast<std::size_t>(std::clamp(surface_length / 0.5, 8.0, 2000.0));
  std::vector<dvec3> taut{line.front()};
  std::size_t at = 1;
  double so_far = 0;
  for (std::size_t i = 1; i < steps; ++i) {
    const double target = surface_length * static_cast<double>(i) / static_cast<double>(steps);
    while (at + 1 < line.size() && so_far + glm::length(line[at] - line[at - 1]) < target)
      so_far += glm::length(line[at] - line[at - 1]), ++at;
    const double edge = glm::length(line[at] - line[at - 1]);
    const double t = edge > 0 ? std::clamp((target - so_far) / edge, 0.0, 1.0) : 0;
    taut.push_back(line[at - 1] + t * (line[at] - line[at - 1]));
  }
  taut.push_back(line.back());
  // Pulls each node toward the middle of two neighbours, at first distant ones, and pushes the node out again
  // if it is inside the solid. The steps are small, so that a node never passes through a wall.
  constexpr double k_step = 0.25;  // mm
  const auto relax = [&](std::size_t reach, int rounds) {
    double length = length_of(taut);
    for (int round = 0; round < rounds; ++round) {
      for (std::size_t i = 1; i + 1 < taut.size(); ++i) {
        const std::size_t r = std::min({reach, i, taut.size() - 1 - i});
        const dvec3 pull = 0.5 * (taut[i - r] + taut[i + r]) - taut[i];
        const double size = glm::length(pull);
        taut[i] += size > k_step ? k_step / size * pull : pull;
        for (int out = 0; out < 8; ++out) {
          const Inside is = inside(taut[i]);
          if (!(is.depth > 1e-4)) break;
          taut[i] += is.depth * is.outward;
        }
      }
      const double now = length_of(taut);
      if (round > 20 && std::abs(now - length) < 1e-7 * length) break;
      length = now;
    }
  };
  for (std::size_t reach = taut.size() / 4; reach > 1; reach /= 2) relax(reach, 300);
  relax(1, 1000);
  if (length_of(taut) > surface_length) return line;  // noise of the solid pushed nodes outward
  return taut;
}

}  // namespace trephine::haptics
