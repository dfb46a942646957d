#include "volume/part_surface.h"

#include <algorithm>
#include <cstring>
#include <glm/common.hpp>
#include <glm/matrix.hpp>
#include <glm/vector_relational.hpp>
#include <unordered_map>

#include "volume/removal.h"
#include "volume/surface_nets.h"

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
  // The net reaches a voxel beyond the part. Another voxel on, whatever is there is another part's.
  const VoxelBox& box = parts.parts()[static_cast<std::size_t>(part)].box;
  std::vector<std::uint8_t> others(parts.parts().size(), 1);
  others[static_cast<std::size_t>(part)] = 0;
  RemovalEditor editor(version, {});
  editor.take_out(parts, others, {box.low - 2, box.high + 2});
  const auto alone = editor.freeze();

  PartSurface surface;
  const Frame& frame = version->base().frame;
  const bool is_turned = glm::determinant(frame.axes()) < 0;
  std::unordered_map<glm::vec3, std::uint32_t, HashOfBits> known;  // chunks share vertices along their border
  const SurfaceSource source{&field, alone.get(), &bits};
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
          for (const int k : {0, is_turned ? 2 : 1, is_turned ? 1 : 2}) {
            const glm::vec3& p = mesh.vertices[corners[k]];
            const auto [at, is_new] = known.emplace(p, static_cast<std::uint32_t>(known.size()));
            if (is_new) surface.vertices_world.emplace_back(frame.world_from_volume(glm::dvec3(p)));
            surface.triangles.push_back(at->second);
          }
        }
      }
  return surface;
}

}  // namespace trephine::volume
