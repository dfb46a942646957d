// Naive surface nets (Gibson 1998; vertex = mean of a patch's edge crossings), closed and manifold.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>

#include "volume/base/buffer.h"
#include "volume/cuts/version.h"
#include "volume/scan/field.h"
#include "volume/scan/occupancy.h"

namespace trephine::volume {

/// Triangles in the volume frame (voxel units), counter-clockwise when viewed from the free side (in a
/// right-handed frame).
struct Mesh {
  Buffer<glm::vec3> vertices;
  Buffer<std::uint32_t> triangles;  ///< three vertex indices each

  std::size_t triangle_count() const { return triangles.size() / 3; }
  std::size_t bytes() const { return vertices.bytes() + triangles.bytes(); }
};

/// Input of a surface net, borrowed for the call.
struct SurfaceSource {
  const Field* field;
  const Version* version = nullptr;  ///< null: no cuts
  const Occupancy* bits = nullptr;   ///< bits of the field's shape; null: thresholds the volume
  bool is_open = false;              ///< leave holes where the solid reaches the grid's border
  /// True: uses voxel centres only, with each vertex at the mean of its crossings: the net that a proxy
  /// touches (volume/surface/local_net.h). False: cuts have the resolution of their lattice, and sharp
  /// rims.
  bool uses_voxel_centres_only = false;
};

/// Returns the whole surface, with one vertex per surface patch of a cell (the cube between eight voxel
/// centres). An ambiguous face disconnects its solid corners. If a patch in each of the two cells at the
/// face would then touch itself there, the face disconnects its air corners instead. The result does not
/// depend on `threads` (0 = all cores).
Mesh surface_net(const SurfaceSource& source, int threads = 0);

/// Cells along the edge of a chunk.
inline constexpr int k_chunk = 32;

/// Returns the number of chunks along each axis of a volume, whose cells are -1 .. size - 1.
inline glm::ivec3 chunk_grid(const glm::ivec3& size) { return (size + 1 + (k_chunk - 1)) / k_chunk; }
/// Range of chunks, both ends included.
struct ChunkRange {
  glm::ivec3 first, last;
};
/// Returns the chunks to rebuild after a change of voxels low .. high. `size`: of the volume.
ChunkRange chunks_touching(const glm::ivec3& low, const glm::ivec3& high, const glm::ivec3& size);

/// Working memory of a thread, reused between chunks.
struct NetScratch {
  Buffer<glm::vec3> vertices;
  Buffer<std::uint32_t> triangles;
};

/// Returns the triangles of one chunk with their vertices, bit-identical to those of the whole surface.
Mesh surface_net_chunk(const SurfaceSource& source, const glm::ivec3& chunk, NetScratch* scratch = nullptr);

/// Returns unit normals (world frame) at the vertices of a mesh, toward the free side, from the gradients of
/// the field and the cuts.
Buffer<glm::vec3> vertex_normals(const SurfaceSource& source, const Mesh& mesh, int threads = 0);

}  // namespace trephine::volume
