// A whole surface from its single cells: for small volumes and for judges, who look at one thread's plain
// work.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <map>
#include <set>
#include <vector>

#include "volume/surface_nets.h"

namespace trephine::volume {

/// The triangles of cells -1 .. size - 1, each once; vertices of the same bits are one. `local`: a LocalNet
/// or LocalCubes.
/// `bits`: of the voxels, to pass over what is empty.
template <class Local>
Mesh mesh_of_cells(const Local& local, const glm::ivec3& size, bool is_joined = true,
                   const Occupancy* bits = nullptr) {
  const auto key = [](const glm::vec3& v) {
    return std::array<std::uint32_t, 3>{std::bit_cast<std::uint32_t>(v.x), std::bit_cast<std::uint32_t>(v.y),
                                        std::bit_cast<std::uint32_t>(v.z)};
  };
  std::map<std::array<std::uint32_t, 3>, std::uint32_t> numbers;
  std::set<std::array<std::uint32_t, 3>> used;
  std::vector<glm::vec3> vertices;
  std::vector<std::uint32_t> triangles;
  const auto number = [&](const glm::vec3& v) {
    const auto [at, is_new] = numbers.try_emplace(key(v), static_cast<std::uint32_t>(vertices.size()));
    if (is_new) vertices.push_back(v);
    return at->second;
  };
  for (int z = -1; z < size.z; ++z)
    for (int y = -1; y < size.y; ++y)
      for (int x = -1; x < size.x; ++x) {
        // Two empty blocks away nothing is crossed up to the end of this one.
        if (bits && x >= 0 && y >= 0 && z >= 0 && bits->empty_distance({x, y, z}) > 1) {
          x |= 3;
          continue;
        }
        local.triangles_of_cell({x, y, z}, [&](const glm::vec3& a, const glm::vec3& b, const glm::vec3& c) {
          if (!is_joined) {
            for (const glm::vec3& v : {a, b, c}) {
              triangles.push_back(static_cast<std::uint32_t>(vertices.size()));
              vertices.push_back(v);
            }
            return;
          }
          const std::array<std::uint32_t, 3> triangle{number(a), number(b), number(c)};
          // A net's quad is seen from each of its four cells.
          if (used.insert(triangle).second)
            triangles.insert(triangles.end(), triangle.begin(), triangle.end());
        });
      }
  Mesh mesh{Buffer<glm::vec3>(vertices.size()), Buffer<std::uint32_t>(triangles.size())};
  std::copy(vertices.begin(), vertices.end(), mesh.vertices.data());
  std::copy(triangles.begin(), triangles.end(), mesh.triangles.data());
  return mesh;
}

}  // namespace trephine::volume
