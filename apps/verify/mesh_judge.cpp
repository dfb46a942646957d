#include "apps/verify/mesh_judge.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <numeric>
#include <set>
#include <vector>

namespace trephine::verify {

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
      ++verdict.non_manifold_edges;
    else if (forward != 1)
      ++verdict.twisted_edges;
    i = end;
  }
  // A vertex is pinched if the triangles around it form several groups that share no edge.
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
    std::vector<std::size_t> open{0};
    is_reached[0] = true;
    std::size_t reached = 0;
    while (!open.empty()) {
      const std::size_t i = open.back();
      open.pop_back();
      ++reached;
      for (std::size_t j = 0; j < count; ++j) {
        if (is_reached[j]) continue;
        int shared = 0;  // common vertices other than v
        for (int a = 0; a < 3; ++a)
          for (int b = 0; b < 3; ++b) {
            const std::uint32_t x = triangles[3 * around[first + i] + static_cast<std::size_t>(a)];
            shared += x != v && x == triangles[3 * around[first + j] + static_cast<std::size_t>(b)];
          }
        if (shared > 0) is_reached[j] = true, open.push_back(j);
      }
    }
    if (reached != count) ++verdict.pinched_vertices;
  }
  return verdict;
}

namespace {

glm::ivec3 cube_of(const glm::dvec3& p) {
  return {static_cast<int>(std::floor(p.x)), static_cast<int>(std::floor(p.y)),
          static_cast<int>(std::floor(p.z))};
}
std::uint64_t key_of(int x, int y, int z) {
  const auto part = [](int i) { return static_cast<std::uint64_t>(i + (1 << 20)); };
  return part(x) << 42 | part(y) << 21 | part(z);
}

using Long = long double;
struct LongVector {
  Long x, y, z;
};
LongVector minus(const glm::dvec3& a, const glm::dvec3& b) {
  return {static_cast<Long>(a.x) - b.x, static_cast<Long>(a.y) - b.y, static_cast<Long>(a.z) - b.z};
}
LongVector cross(const LongVector& a, const LongVector& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
Long dot(const LongVector& a, const LongVector& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }

constexpr std::uint32_t k_none = ~0u;

/// Returns true if a and b are on different sides of the triangle's plane, and the segment between them is
/// inside its three edges.
bool crosses(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& u, const glm::dvec3& v,
             const glm::dvec3& w) {
  // If the boxes of segment and triangle do not touch, there is no crossing.
  for (int i = 0; i < 3; ++i)
    if (std::max(a[i], b[i]) < std::min({u[i], v[i], w[i]}) ||
        std::min(a[i], b[i]) > std::max({u[i], v[i], w[i]}))
      return false;
  const LongVector normal = cross(minus(v, u), minus(w, u));
  const Long from = dot(minus(a, u), normal), to = dot(minus(b, u), normal);
  if ((from > 0) == (to > 0) || from == to) return false;
  const LongVector segment = minus(b, a);
  const auto side = [&](const glm::dvec3& p, const glm::dvec3& q) {
    return dot(segment, cross(minus(p, a), minus(q, a)));
  };
  const Long x = side(u, v), y = side(v, w), z = side(w, u);
  return (x >= 0 && y >= 0 && z >= 0) || (x <= 0 && y <= 0 && z <= 0);
}

}  // namespace

MeshWall::MeshWall(std::span<const glm::vec3> vertices, std::span<const std::uint32_t> triangles)
    : MeshWall(std::vector<glm::dvec3>(vertices.begin(), vertices.end()), triangles, 1) {}

MeshWall::MeshWall(std::span<const glm::dvec3> vertices, std::span<const std::uint32_t> triangles,
                   double cube)
    : vertices_(vertices.begin(), vertices.end()),
      triangles_(triangles.begin(), triangles.end()),
      cube_(cube) {
  for (std::size_t i = 0; i < triangles_.size(); i += 3) {
    glm::dvec3 low = vertices_[triangles_[i]], high = low;
    for (std::size_t k = 1; k < 3; ++k) {
      low = glm::min(low, vertices_[triangles_[i + k]]);
      high = glm::max(high, vertices_[triangles_[i + k]]);
    }
    top_ = std::max(top_, high.z);
    const glm::ivec3 first = cube_of(low / cube_), last = cube_of(high / cube_);
    first_cube_ = i == 0 ? first : glm::min(first_cube_, first);
    last_cube_ = i == 0 ? last : glm::max(last_cube_, last);
    for (int z = first.z; z <= last.z; ++z)
      for (int y = first.y; y <= last.y; ++y)
        for (int x = first.x; x <= last.x; ++x) {
          const auto [newest, is_first] = newest_in_cube_.try_emplace(key_of(x, y, z), k_none);
          near_.push_back({static_cast<std::uint32_t>(i), newest->second});
          newest->second = static_cast<std::uint32_t>(near_.size() - 1);
        }
  }
}

std::set<std::uint32_t> MeshWall::crossed(const glm::dvec3& a, const glm::dvec3& b) const {
  std::set<std::uint32_t> crossed;
  // All cubes near the segment, in steps of half a cube, and their neighbours.
  const double length = glm::length(b - a) / cube_;
  const int steps = 1 + static_cast<int>(2 * length);
  glm::ivec3 last(1 << 19);
  for (int s = 0; s <= steps; ++s) {
    const glm::ivec3 cube = cube_of((a + (static_cast<double>(s) / steps) * (b - a)) / cube_);
    if (cube == last) continue;
    for (int z = -1; z <= 1; ++z)
      for (int y = -1; y <= 1; ++y)
        for (int x = -1; x <= 1; ++x) {
          const glm::ivec3 neighbour = cube + glm::ivec3(x, y, z), offset = glm::abs(neighbour - last);
          if (std::max({offset.x, offset.y, offset.z}) <= 1) continue;  // visited with the last cube
          const auto newest = newest_in_cube_.find(key_of(neighbour.x, neighbour.y, neighbour.z));
          if (newest == newest_in_cube_.end()) continue;
          for (std::uint32_t n = newest->second; n != k_none; n = near_[n].next) {
            const std::uint32_t i = near_[n].triangle;
            if (crosses(a, b, vertices_[triangles_[i]], vertices_[triangles_[i + 1]],
                        vertices_[triangles_[i + 2]]))
              crossed.insert(i);
          }
        }
    last = cube;
  }
  return crossed;
}

bool MeshWall::is_entered(const glm::dvec3& a, const glm::dvec3& b) const {
  for (const std::uint32_t i : crossed(a, b)) {
    const glm::dvec3 &p = vertices_[triangles_[i]], &q = vertices_[triangles_[i + 1]],
                     &r = vertices_[triangles_[i + 2]];
    if (glm::dot(b - a, glm::cross(q - p, r - p)) < 0) return true;
  }
  return false;
}

std::vector<MeshWall::Crossing> MeshWall::crossings_along(const glm::dvec3& a, const glm::dvec3& b) const {
  std::vector<Crossing> result;
  for (const std::uint32_t i : crossed(a, b)) {
    const glm::dvec3 &p = vertices_[triangles_[i]], &q = vertices_[triangles_[i + 1]],
                     &r = vertices_[triangles_[i + 2]];
    const glm::dvec3 normal = glm::normalize(glm::cross(q - p, r - p));
    result.push_back({glm::dot(p - a, normal) / glm::dot(b - a, normal), normal});
  }
  std::sort(result.begin(), result.end(), [](const Crossing& x, const Crossing& y) { return x.at < y.at; });
  const auto is_same = [&](const Crossing& x, const Crossing& y) {
    return y.at - x.at < 1e-9 && (glm::dot(x.normal, b - a) > 0) == (glm::dot(y.normal, b - a) > 0);
  };
  result.erase(std::unique(result.begin(), result.end(), is_same), result.end());
  return result;
}

template <class Each>
void MeshWall::for_near(const glm::dvec3& p, double reach, const Each& each) const {
  const glm::ivec3 first = glm::max(cube_of((p - reach) / cube_), first_cube_),
                   last = glm::min(cube_of((p + reach) / cube_), last_cube_);
  for (int z = first.z; z <= last.z; ++z)
    for (int y = first.y; y <= last.y; ++y)
      for (int x = first.x; x <= last.x; ++x) {
        const auto newest = newest_in_cube_.find(key_of(x, y, z));
        if (newest == newest_in_cube_.end()) continue;
        for (std::uint32_t n = newest->second; n != k_none; n = near_[n].next) {
          const std::uint32_t i = near_[n].triangle;
          if (each(i)) return;
        }
      }
}

namespace {

/// Returns the point of a triangle nearest to p: the foot on its plane, or a point of its edges.
glm::dvec3 nearest_point(const glm::dvec3& p, const glm::dvec3& u, const glm::dvec3& v, const glm::dvec3& w) {
  const glm::dvec3 normal = glm::cross(v - u, w - u);
  const double square = glm::dot(normal, normal);
  if (square > 0) {
    const glm::dvec3 foot = p - glm::dot(p - u, normal) / square * normal;
    if (glm::dot(glm::cross(v - u, foot - u), normal) >= 0 &&
        glm::dot(glm::cross(w - v, foot - v), normal) >= 0 &&
        glm::dot(glm::cross(u - w, foot - w), normal) >= 0)
      return foot;
  }
  glm::dvec3 nearest = u;
  for (const auto& [from, to] : {std::pair(u, v), std::pair(v, w), std::pair(w, u)}) {
    const glm::dvec3 edge = to - from;
    const double length = glm::dot(edge, edge);
    const double share = length > 0 ? std::clamp(glm::dot(p - from, edge) / length, 0.0, 1.0) : 0;
    if (glm::length(from + share * edge - p) < glm::length(nearest - p)) nearest = from + share * edge;
  }
  return nearest;
}

}  // namespace

bool MeshWall::is_near(const glm::dvec3& p, double reach) const {
  bool is_found = false;
  for_near(p, reach, [&](std::uint32_t i) {
    const glm::dvec3 point = nearest_point(p, vertices_[triangles_[i]], vertices_[triangles_[i + 1]],
                                           vertices_[triangles_[i + 2]]);
    return is_found = is_found || glm::length(point - p) <= reach;
  });
  return is_found;
}

double MeshWall::distance(const glm::dvec3& p, double reach) const {
  constexpr double k_same = 1e-9;  // mm, tolerance of equal distances
  struct Near {
    std::uint32_t triangle;
    glm::dvec3 point;
  };
  std::vector<Near> near;
  double least = reach;
  for_near(p, reach, [&](std::uint32_t i) {
    const glm::dvec3 point = nearest_point(p, vertices_[triangles_[i]], vertices_[triangles_[i + 1]],
                                           vertices_[triangles_[i + 2]]);
    const double gap = glm::length(point - p);
    if (gap <= least + k_same) near.push_back({i, point});
    least = std::min(least, gap);
    return false;
  });
  glm::dvec3 nearest(0), normal(0);
  std::set<std::uint32_t> counted;
  bool is_found = false;
  for (const Near& candidate : near) {
    if (glm::length(candidate.point - p) > least + k_same) continue;
    if (!is_found) nearest = candidate.point, is_found = true;
    if (glm::length(candidate.point - nearest) > 1e-6 || !counted.insert(candidate.triangle).second) continue;
    const glm::dvec3 corners[3] = {vertices_[triangles_[candidate.triangle]],
                                   vertices_[triangles_[candidate.triangle + 1]],
                                   vertices_[triangles_[candidate.triangle + 2]]};
    const glm::dvec3 across = glm::cross(corners[1] - corners[0], corners[2] - corners[0]);
    if (!(glm::length(across) > 0)) continue;
    double weight = 1;  // at a corner: the triangle's angle there
    for (int k = 0; k < 3; ++k)
      if (glm::length(corners[k] - nearest) < 1e-6) {
        const glm::dvec3 a = glm::normalize(corners[(k + 1) % 3] - corners[k]),
                         b = glm::normalize(corners[(k + 2) % 3] - corners[k]);
        weight = std::acos(std::clamp(glm::dot(a, b), -1.0, 1.0));
      }
    normal += weight * glm::normalize(across);
  }
  if (!is_found) return reach;
  return glm::dot(p - nearest, normal) < 0 ? -least : least;
}

std::vector<glm::dvec3> MeshWall::pushes_near(const glm::dvec3& p, double slack, double reach) const {
  constexpr double k_on = 0.01;  // mm: at a smaller distance p is on the triangle
  std::vector<std::pair<double, glm::dvec3>> near;
  double least = reach;
  for_near(p, reach, [&](std::uint32_t i) {
    const glm::dvec3 &u = vertices_[triangles_[i]], &v = vertices_[triangles_[i + 1]],
                     &w = vertices_[triangles_[i + 2]];
    const glm::dvec3 offset = p - nearest_point(p, u, v, w), across = glm::cross(v - u, w - u);
    const double gap = glm::length(offset);
    if (glm::length(across) > 0) near.emplace_back(gap, gap > k_on ? offset / gap : glm::normalize(across));
    least = std::min(least, gap);
    return false;
  });
  std::vector<glm::dvec3> pushes;
  for (const auto& [gap, push] : near)
    if (gap <= least + slack) pushes.push_back(push);
  return pushes;
}

bool MeshWall::is_inside(const glm::dvec3& p) const {
  // The segment leads upward, slightly oblique, since a segment along z might meet edges of the mesh.
  const double up = top_ + cube_ - p.z;
  return up > 0 && crossings(p, p + up * glm::dvec3(0.0113, 0.0071, 1)) % 2 == 1;
}

}  // namespace trephine::verify
