#include "haptics/baselines/voxmap.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <utility>

namespace trephine::haptics::baselines {

using glm::dvec3;
using glm::ivec3;

namespace {

std::size_t index_of(const ivec3& size, const ivec3& v) noexcept {
  return static_cast<std::size_t>(v.x) +
         static_cast<std::size_t>(size.x) *
             (static_cast<std::size_t>(v.y) +
              static_cast<std::size_t>(size.y) * static_cast<std::size_t>(v.z));
}
bool is_in(const ivec3& size, const ivec3& v) noexcept {
  return v.x >= 0 && v.y >= 0 && v.z >= 0 && v.x < size.x && v.y < size.y && v.z < size.z;
}
template <class Use>
void for_each_voxel(const ivec3& low, const ivec3& high, Use&& use) {
  for (int z = low.z; z <= high.z; ++z)
    for (int y = low.y; y <= high.y; ++y)
      for (int x = low.x; x <= high.x; ++x) use(ivec3(x, y, z));
}

/// Returns true if a triangle meets a cube of half edge 0.5 around the origin: no axis separates them.
bool meets_cube(const dvec3& a, const dvec3& b, const dvec3& c) noexcept {
  const auto is_separating = [&](const dvec3& axis) {
    const double p = glm::dot(axis, a), q = glm::dot(axis, b), r = glm::dot(axis, c);
    const double reach = 0.5 * (std::abs(axis.x) + std::abs(axis.y) + std::abs(axis.z));
    return std::min({p, q, r}) > reach || std::max({p, q, r}) < -reach;
  };
  const dvec3 edges[] = {b - a, c - b, a - c};
  const dvec3 units[] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  for (const dvec3& unit : units)
    if (is_separating(unit)) return false;
  if (is_separating(glm::cross(edges[0], edges[1]))) return false;
  for (const dvec3& edge : edges)
    for (const dvec3& unit : units)
      if (is_separating(glm::cross(edge, unit))) return false;
  return true;
}

}  // namespace

VoxMap VoxMap::of(const volume::Occupancy& solid, const volume::Frame& frame, int layers) {
  VoxMap map(frame, solid.size());
  std::vector<Voxel> voxels(index_of(map.size_, {0, 0, map.size_.z}), Voxel::free);
  for_each_voxel(ivec3(0), map.size_ - 1, [&](const ivec3& v) {
    if (!solid.is_solid(v)) return;
    bool is_interior = true;
    for_each_voxel(v - 1, v + 1, [&](const ivec3& w) {
      is_interior = is_interior && is_in(map.size_, w) && solid.is_solid(w);
    });
    voxels[index_of(map.size_, v)] = is_interior ? Voxel::interior : Voxel::surface;
  });
  map.build(std::move(voxels), layers);
  return map;
}

namespace {

/// Twice the signed area of p, q and the point (y, z) in the plane of y and z. Exactly the negative if p and
/// q are swapped.
double side(const dvec3& p, const dvec3& q, double y, double z) noexcept {
  const bool is_swapped = std::pair(q.y, q.z) < std::pair(p.y, p.z);
  const dvec3 &from = is_swapped ? q : p, &to = is_swapped ? p : q;
  const double value = (to.y - from.y) * (z - from.z) - (to.z - from.z) * (y - from.y);
  return is_swapped ? -value : value;
}

}  // namespace

VoxMap VoxMap::of(const MeshTree& mesh, double voxel, Interior interior, int layers) {
  const int border = layers + 2;
  // 0.37: the low corner of the mesh is not at the border of a voxel.
  const dvec3 origin = mesh.low() - (border + 0.37) * voxel;
  const ivec3 size = ivec3(glm::ceil((mesh.high() - origin) / voxel)) + border + 1;
  VoxMap map(volume::Frame::from_spacing(origin, dvec3(voxel)).value(), size);
  // Until they are known to be free, voxels belong to the interior.
  std::vector<Voxel> voxels(index_of(size, {0, 0, size.z}), Voxel::interior);
  for (std::uint32_t t = 0; t < mesh.triangle_count(); ++t) {
    std::array<dvec3, 3> corners = mesh.corners(t);
    for (dvec3& corner : corners) corner = (corner - origin) / voxel;
    const dvec3 low = glm::min(corners[0], glm::min(corners[1], corners[2])),
                high = glm::max(corners[0], glm::max(corners[1], corners[2]));
    for_each_voxel(ivec3(glm::floor(low + 0.5)), ivec3(glm::floor(high + 0.5)), [&](const ivec3& v) {
      const dvec3 centre(v);
      if (meets_cube(corners[0] - centre, corners[1] - centre, corners[2] - centre))
        voxels[index_of(size, v)] = Voxel::surface;
    });
  }
  const auto at = [&](const ivec3& v) -> Voxel& { return voxels[index_of(size, v)]; };
  if (interior == Interior::parity) {
    for (int z = 0; z < size.z; ++z)
      for (int y = 0; y < size.y; ++y) {
        const dvec3 row = origin + voxel * dvec3(-1, y, z);
        // Positions (mm, along x) at which the row of voxel centres crosses the mesh.
        std::vector<double> crossings;
        for (std::uint32_t t = 0; t < mesh.triangle_count(); ++t) {
          auto [a, b, c] = mesh.corners(t);
          if (side(a, b, c.y, c.z) < 0) std::swap(b, c);
          const double u = side(b, c, row.y, row.z), v = side(c, a, row.y, row.z),
                       w = side(a, b, row.y, row.z);
          // A common edge of two triangles, and the rows through it, belong to one of them.
          const auto is_inside = [](double value, const dvec3& p, const dvec3& q) {
            return value > 0 || (value == 0 && (q.z < p.z || (q.z == p.z && q.y > p.y)));
          };
          if (!(u + v + w > 0) || !is_inside(u, b, c) || !is_inside(v, c, a) || !is_inside(w, a, b)) continue;
          crossings.push_back((u * a.x + v * b.x + w * c.x) / (u + v + w));
        }
        std::sort(crossings.begin(), crossings.end());
        std::size_t passed = 0;
        for (int x = 0; x < size.x; ++x) {
          const double p = origin.x + voxel * x;
          while (passed < crossings.size() && crossings[passed] < p) ++passed;
          if (Voxel& v = at({x, y, z}); v == Voxel::interior && passed % 2 == 0) v = Voxel::free;
        }
      }
  } else {
    for (int pass = 0, changed = 1; pass < k_passes && changed > 0; ++pass) {
      changed = 0;
      for (int axis = 0; axis < 3; ++axis)
        for (const int step : {1, -1}) {
          // The wall moves along the axis: a voxel becomes free if the previous voxel is free, or outside the
          // map.
          ivec3 from(0), to = size - 1;
          const auto advance = [&](const ivec3& v) {
            ivec3 before = v;
            before[axis] -= step;
            Voxel& here = at(v);
            if (here == Voxel::interior && (!is_in(size, before) || at(before) == Voxel::free))
              here = Voxel::free, ++changed;
          };
          const int first = step > 0 ? 0 : size[axis] - 1;
          for (int i = 0; i < size[axis]; ++i) {
            from[axis] = to[axis] = first + step * i;
            for_each_voxel(from, to, advance);
          }
        }
    }
  }
  map.build(std::move(voxels), layers);
  return map;
}

void VoxMap::build(std::vector<Voxel> voxels, int layers) {
  const auto at = [&](const ivec3& v) -> Voxel& { return voxels[index_of(size_, v)]; };
  std::vector<ivec3> border;
  for_each_voxel(ivec3(0), size_ - 1, [&](const ivec3& v) {
    if (at(v) == Voxel::surface) border.push_back(v);
  });
  for (int layer = 0; layer < layers; ++layer) {
    std::vector<ivec3> next;
    for (const ivec3& v : border)
      for_each_voxel(glm::max(v - 1, ivec3(0)), glm::min(v + 1, size_ - 1), [&](const ivec3& w) {
        if (at(w) == Voxel::free) at(w) = Voxel::proximity, next.push_back(w);
      });
    border = std::move(next);
  }
  int edge = 8;
  for (; edge < std::max({size_.x, size_.y, size_.z}); edge *= 8) ++levels_;
  // Returns an aggregate, or the index of a new node or leaf, for the cube at `low` with `size` voxels along
  // an edge.
  const std::function<std::uint32_t(const ivec3&, int)> node_of = [&](const ivec3& low, int size) {
    const auto child_size = size / 8;
    std::array<std::uint32_t, 512> children;
    bool is_uniform = true;
    for (int i = 0; i < 512; ++i) {
      const ivec3 v = low + child_size * ivec3(i & 7, i >> 3 & 7, i >> 6);
      std::uint32_t& child = children[static_cast<std::size_t>(i)];
      if (!is_in(size_, v))
        child = k_value | static_cast<std::uint32_t>(Voxel::undefined);
      else if (child_size == 1)
        child = k_value | static_cast<std::uint32_t>(at(v));
      else
        child = node_of(v, child_size);
      is_uniform = is_uniform && (child & k_value) != 0 && child == children[0];
    }
    if (is_uniform) return children[0];
    if (child_size == 1) {
      const auto index = static_cast<std::uint32_t>(leaves_.size() / 512);
      for (const std::uint32_t child : children) leaves_.push_back(static_cast<std::uint8_t>(child & 0xff));
      return index;
    }
    const auto index = static_cast<std::uint32_t>(nodes_.size() / 512);
    nodes_.insert(nodes_.end(), children.begin(), children.end());
    return index;
  };
  root_ = node_of(ivec3(0), edge);
}

VoxMap::Cell VoxMap::cell_at(const ivec3& v) const noexcept {
  if (!is_in(size_, v)) return {Voxel::undefined, v, 1};
  std::uint32_t node = root_;
  const auto cell = [&](int edge_bits) -> Cell {
    return {static_cast<Voxel>(node & 0xff), (v >> edge_bits) << edge_bits, 1 << edge_bits};
  };
  for (int level = levels_ - 1; level >= 0; --level) {
    const int shift = 3 * level;
    if (node & k_value) return cell(shift + 3);
    const auto child =
        static_cast<std::size_t>((v.x >> shift & 7) | (v.y >> shift & 7) << 3 | (v.z >> shift & 7) << 6);
    const std::size_t slot = 512 * static_cast<std::size_t>(node) + child;
    node = level == 0 ? k_value | leaves_[slot] : nodes_[slot];
  }
  return cell(0);
}

bool VoxMap::is_free_in(std::uint32_t node, int level, const ivec3& corner, const ivec3& low,
                        const ivec3& high) const noexcept {
  if (level < 0 || (node & k_value) != 0) {
    const auto type = static_cast<Voxel>(node & 0xff);
    return type == Voxel::free || type == Voxel::undefined;
  }
  const int shift = 3 * level;
  const ivec3 first = glm::max((low - corner) >> shift, ivec3(0)),
              last = glm::min((high - corner) >> shift, ivec3(7));
  for (int z = first.z; z <= last.z; ++z)
    for (int y = first.y; y <= last.y; ++y)
      for (int x = first.x; x <= last.x; ++x) {
        const auto slot =
            512 * static_cast<std::size_t>(node) + static_cast<std::size_t>(x | y << 3 | z << 6);
        const std::uint32_t child = level == 0 ? k_value | leaves_[slot] : nodes_[slot];
        if (!is_free_in(child, level - 1, corner + (ivec3(x, y, z) << shift), low, high)) return false;
      }
  return true;
}

bool VoxMap::is_free(const ivec3& low, const ivec3& high) const noexcept {
  const ivec3 a = glm::max(low, ivec3(0)), b = glm::min(high, size_ - 1);
  if (a.x > b.x || a.y > b.y || a.z > b.z) return true;
  return is_free_in(root_, levels_ - 1, ivec3(0), a, b);
}

}  // namespace trephine::haptics::baselines
