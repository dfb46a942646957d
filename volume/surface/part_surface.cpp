#include "volume/surface/part_surface.h"

#include <algorithm>
#include <cstring>
#include <glm/common.hpp>
#include <glm/matrix.hpp>
#include <glm/vector_relational.hpp>
#include <unordered_map>

#include "volume/cuts/removal.h"
#include "volume/surface/surface_nets.h"

namespace trephine::volume {

namespace {
struct HashOfBits {
  std::size_t operator()(const glm::vec3& v) const noexcept {
    std::uint32_t bits[3];
    std::memcpy(bits, &v, sizeof bits);
    return (bits[0] * 73856093u) ^ (bits[1] * 19349663u) ^ (bits[2] * 83492791u);
  }
};
}  // namespace

PartSurface part_surface(const Field& field, const Occupancy& bits,
                         const std::shared_ptr<const Version>& version, const SolidParts& parts, int part) {
  // Other parts are removed up to two voxels outside the box: the net reads one voxel beyond it, and matter
  // in the second voxel would leave triangles there.
  const VoxelBox& box = parts.parts()[static_cast<std::size_t>(part)].box;
  std::vector<std::uint8_t> is_other(parts.parts().size(), 1);
  is_other[static_cast<std::size_t>(part)] = 0;
  RemovalEditor editor(version, {});
  editor.remove_parts(parts, is_other, {box.low - 2, box.high + 2});
  const auto isolated = editor.freeze();

  PartSurface surface;
  const Frame& frame = version->base().frame;
  const bool is_left_handed = glm::determinant(frame.axes()) < 0;
  // Merges the vertices that chunks share along their borders.
  std::unordered_map<glm::vec3, std::uint32_t, HashOfBits> vertex_ids;
  const SurfaceSource source{&field, isolated.get(), &bits};
  const ChunkRange chunks = chunks_touching(box.low - 1, box.high + 1, version->base().size);
  NetScratch scratch;
  for (int z = chunks.first.z; z <= chunks.last.z; ++z)
    for (int y = chunks.first.y; y <= chunks.last.y; ++y)
      for (int x = chunks.first.x; x <= chunks.last.x; ++x) {
        const Mesh mesh = surface_net_chunk(source, {x, y, z}, &scratch);
        const auto is_inside = [&](std::uint32_t v) {
          const glm::vec3& p = mesh.vertices[v];
          return glm::all(glm::greaterThan(p, glm::vec3(box.low) - 1.5f)) &&
                 glm::all(glm::lessThan(p, glm::vec3(box.high) + 1.5f));
        };
        for (std::size_t t = 0; t < mesh.triangles.size(); t += 3) {
          const std::uint32_t* corners = mesh.triangles.data() + t;
          if (!std::all_of(corners, corners + 3, is_inside)) continue;
          for (const int k : {0, is_left_handed ? 2 : 1, is_left_handed ? 1 : 2}) {
            const glm::vec3& p = mesh.vertices[corners[k]];
            const auto [entry, is_new] = vertex_ids.emplace(p, static_cast<std::uint32_t>(vertex_ids.size()));
            if (is_new) surface.vertices_world.emplace_back(frame.world_from_volume(glm::dvec3(p)));
            surface.triangles.push_back(entry->second);
          }
        }
      }
  return surface;
}

}  // namespace trephine::volume
