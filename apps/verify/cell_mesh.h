// mesh_of_cells(): builds a whole surface cell by cell on one thread, for small volumes and for judges.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <unordered_map>
#include <vector>

#include "volume/surface/local_net.h"
#include "volume/surface/marching_cubes.h"
#include "volume/surface/surface_nets.h"

namespace trephine::verify {

/// Collects triangles into a mesh.
class MeshOfTriangles {
 public:
  /// `is_joined`: vertices with equal bits are merged.
  explicit MeshOfTriangles(bool is_joined) : is_joined_(is_joined) {}

  void add(const glm::vec3& a, const glm::vec3& b, const glm::vec3& c) {
    for (const glm::vec3& v : {a, b, c}) triangles_.push_back(number(v));
  }
  volume::Mesh mesh() const {
    volume::Mesh mesh{Buffer<glm::vec3>(vertices_.size()), Buffer<std::uint32_t>(triangles_.size())};
    std::copy(vertices_.begin(), vertices_.end(), mesh.vertices.data());
    std::copy(triangles_.begin(), triangles_.end(), mesh.triangles.data());
    return mesh;
  }

 private:
  using Key = std::array<std::uint32_t, 3>;
  struct Hash {
    std::size_t operator()(const Key& k) const noexcept {
      return (std::size_t{k[0]} * 0x9e3779b97f4a7c15u ^ k[1]) * 0x9e3779b97f4a7c15u ^ k[2];
    }
  };
  std::uint32_t number(const glm::vec3& v) {
    const auto next = static_cast<std::uint32_t>(vertices_.size());
    if (is_joined_) {
      const Key key{std::bit_cast<std::uint32_t>(v.x), std::bit_cast<std::uint32_t>(v.y),
                    std::bit_cast<std::uint32_t>(v.z)};
      if (const auto [at, is_new] = numbers_.try_emplace(key, next); !is_new) return at->second;
    }
    vertices_.push_back(v);
    return next;
  }

  bool is_joined_;
  std::unordered_map<Key, std::uint32_t, Hash> numbers_;
  std::vector<glm::vec3> vertices_;
  std::vector<std::uint32_t> triangles_;
};

/// Returns the triangles of cells -1 .. size - 1. `bits`: occupancy of the voxels, used to skip empty blocks;
/// may be null.
template <class Samples>
volume::Mesh mesh_of_cells(const volume::LocalCubes<Samples>& cubes, const glm::ivec3& size,
                           bool is_joined = true, const volume::Occupancy* bits = nullptr) {
  MeshOfTriangles triangles(is_joined);
  for (int z = -1; z < size.z; ++z)
    for (int y = -1; y < size.y; ++y)
      for (int x = -1; x < size.x; ++x) {
        // If this block and the next block are empty, the surface crosses no cell up to the end of this
        // block.
        if (bits && x >= 0 && y >= 0 && z >= 0 && bits->empty_distance({x, y, z}) > 1) {
          x |= 3;
          continue;
        }
        cubes.triangles_of_cell({x, y, z}, [&](const glm::vec3& a, const glm::vec3& b, const glm::vec3& c) {
          triangles.add(a, b, c);
        });
      }
  return triangles.mesh();
}

/// Returns the triangles of a net, which has a quad around each crossed edge of the grid.
template <class Samples>
volume::Mesh mesh_of_cells(const volume::LocalNet<Samples>& net, const glm::ivec3& size) {
  MeshOfTriangles triangles(true);
  for (int z = -1; z < size.z; ++z)
    for (int y = -1; y < size.y; ++y)
      for (int x = -1; x < size.x; ++x) {
        const glm::ivec3 low(x, y, z);
        const int config = net.config(low);
        for (int axis = 0; axis < 3; ++axis)
          if ((config & 1) != (config >> (1 << axis) & 1))
            net.quad(low, axis).triangles(
                [&](const glm::vec3& a, const glm::vec3& b, const glm::vec3& c) { triangles.add(a, b, c); });
      }
  return triangles.mesh();
}

}  // namespace trephine::verify
