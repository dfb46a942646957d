// First solid voxels along rays: exact, one at a time or many.
#pragma once

#include <span>

#include "volume/occupancy.h"
#include "volume/traversal.h"

namespace trephine::volume {

class Version;

/// A ray from start to end, volume frame.
struct Ray {
  glm::dvec3 start, end;
};
struct RayHit {
  bool is_hit = false;
  double t = 1;          ///< where the voxel is entered, 0 at start, 1 at end
  glm::ivec3 voxel{-1};  ///< the first solid one
  VoxelFace face;        ///< through which it was entered
};

/// The first solid voxel on the ray: the one that visiting every voxel in turn would find
/// (volume/traversal.h). Empty blocks are crossed in one step. No hit where a
/// coordinate is no number or not below k_traversal_limit: cut endless rays at the grid's box. `version`:
/// what was cut is not solid; null: nothing was.
RayHit first_hit(const Occupancy& bits, const Ray& ray, const Version* version = nullptr) noexcept;

/// First hits of many rays. `hits` is as long as `rays`. threads 0 = all cores.
void first_hits(const Occupancy& bits, std::span<const Ray> rays, std::span<RayHit> hits,
                const Version* version = nullptr, int threads = 1);

}  // namespace trephine::volume
