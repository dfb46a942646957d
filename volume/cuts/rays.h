// Exact queries for the first solid voxel along one ray or many.
#pragma once

#include <span>

#include "volume/scan/occupancy.h"
#include "volume/scan/traversal.h"

namespace trephine::volume {

class Version;

/// Ray from start to end, volume frame.
struct Ray {
  glm::dvec3 start, end;
};
struct RayHit {
  bool is_hit = false;
  double t = 1;          ///< parameter of entry into the voxel, 0 at start, 1 at end
  glm::ivec3 voxel{-1};  ///< first solid voxel
  VoxelFace face;        ///< face of entry
};

/// Returns the first solid voxel on the ray. Crosses empty blocks in one step, with the result of a visit of
/// every voxel in turn (volume/scan/traversal.h). Returns no hit if a coordinate is not finite or its
/// magnitude is not below k_traversal_limit: clip infinite rays to the grid's box. `version`: its removed
/// voxels are not solid; null: nothing was removed.
RayHit first_hit(const Occupancy& bits, const Ray& ray, const Version* version = nullptr) noexcept;

/// Computes the first hits of many rays. `hits` must be as long as `rays`. threads 0 = all cores.
void first_hits(const Occupancy& bits, std::span<const Ray> rays, std::span<RayHit> hits,
                const Version* version = nullptr, int threads = 1);

}  // namespace trephine::volume
