// Naive surface nets (Gibson 1998; vertex = mean of a patch's edge crossings), closed and manifold.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>

#include "volume/buffer.h"
#include "volume/field.h"
#include "volume/occupancy.h"
#include "volume/version.h"

namespace trephine::volume {

/// Triangles in the volume frame (voxel units), seen from the free side counter-clockwise (in a right-handed
/// frame).
struct Mesh {
  Buffer<glm::vec3> vertices;
  Buffer<std::uint32_t> triangles;  ///< three vertex indices each

  std::size_t triangle_count() const { return triangles.size() / 3; }
  std::size_t bytes() const { return vertices.bytes() + triangles.bytes(); }
};

/// Source of the surface. Borrowed for the call.
struct SurfaceSource {
  const Field* field;
  const Version* version = nullptr;  ///< null: the base
  const Occupancy* bits = nullptr;   ///< bits of the field's shape; null: thresholded on the way
  bool is_open = false;              ///< leave holes where the solid reaches the grid's border
  /// The net of the voxels alone, every vertex the mean of its crossings: what a proxy touches cell by cell
  /// (volume/local_net.h). Else cuts are as fine as their lattice, and their rims sharp.
  bool is_of_voxels = false;
};

/// The whole surface. One vertex for each surface patch of a cell (a cell = eight voxel centres); ambiguous
/// faces separate the solid, except where both cells would then pinch. The result does not depend on
/// `threads` (0 = all).
Mesh surface_net(const SurfaceSource& source, int threads = 0);

/// Cells along the edge of a chunk.
inline constexpr int k_chunk = 32;

/// Chunks needed for a volume: its cells are -1 .. size - 1 along each axis.
inline glm::ivec3 chunk_grid(const glm::ivec3& size) { return (size + 1 + (k_chunk - 1)) / k_chunk; }
/// Voxels low .. high changed: the chunks to remesh, both included.
struct ChunkRange {
  glm::ivec3 first, last;
};
ChunkRange chunks_touching(const glm::ivec3& low, const glm::ivec3& high, const glm::ivec3& size);

/// Memory that a thread which remakes many chunks keeps between them.
struct NetScratch {
  Buffer<glm::vec3> vertices;
  Buffer<std::uint32_t> triangles;
};

/// The triangles of one chunk with the vertices they use, the same bits as in the whole surface.
Mesh surface_net_chunk(const SurfaceSource& source, const glm::ivec3& chunk, NetScratch* scratch = nullptr);

/// Unit normals (world frame) at a mesh's vertices, toward the free side, from the field and the cuts.
Buffer<glm::vec3> vertex_normals(const SurfaceSource& source, const Mesh& mesh, int threads = 0);

}  // namespace trephine::volume
