#include "volume/cuts/rays.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "volume/base/parallel.h"
#include "volume/cuts/version.h"

namespace trephine::volume {

using glm::dvec3;
using glm::ivec3;

namespace {

constexpr double k_plane_margin = 1e-9;  // voxels; nearer to a face, rounding may select a wrong voxel
constexpr double k_tie_margin = 1e-12;   // ray parameter; crossings closer than this are in uncertain order
constexpr double k_far = 1 << 20;        // voxels; larger coordinates are too coarse for k_plane_margin
constexpr int k_rays_per_batch = 4096;   // rays per task of a thread

/// Finds the first hit by visits of all voxels and empty boxes on the ray in exact order.
RayHit walk_exactly(const Occupancy& bits, const Ray& ray, const Version* version) noexcept {
  VoxelWalk walk(Segment(ray.start, ray.end), {ivec3(0), bits.size() - 1});
  while (!walk.is_done()) {
    const ivec3& v = walk.voxel();
    const int far = bits.empty_distance(v);
    if (far > 0) {
      const ivec3 block(v.x >> 2, v.y >> 2, v.z >> 2);
      walk.advance_past({4 * (block - (far - 1)), 4 * (block + far) - 1});
      continue;
    }
    if (bits.is_solid(v) && (version == nullptr || version->is_kept(v)))
      return {true, walk.t_enter(), v, walk.face()};
    walk.advance();
  }
  return {};
}

/// Fast variant in plain floating point. Detects the rare cases in which rounding could change the result,
/// and then returns no result.
class PlainWalk {
 public:
  PlainWalk(const Occupancy& bits, const Ray& ray, const Version* version) noexcept
      : size_(bits.size()),
        bits_(bits),
        version_(version),
        start_(ray.start),
        direction_(ray.end - ray.start) {
    for (int a = 0; a < 3; ++a) {
      step_[a] = direction_[a] > 0 ? 1 : direction_[a] < 0 ? -1 : 0;
      inverse_[a] = step_[a] != 0 ? 1 / direction_[a] : 0;
      is_certain_ = is_certain_ && std::abs(start_[a]) < k_far && std::abs(start_[a] + direction_[a]) < k_far;
    }
  }

  /// Returns the hit or a miss; nullopt if the result is uncertain.
  std::optional<RayHit> run() noexcept {
    if (!is_certain_) return std::nullopt;
    bool is_inside = enter();
    while (is_inside && is_certain_) {
      const int far = bits_.empty_distance(voxel_);
      const ivec3 block(voxel_.x >> 2, voxel_.y >> 2, voxel_.z >> 2);
      if (far > 0) {
        is_inside = leave(4 * (block - (far - 1)), 4 * (block + far));
        continue;
      }
      const int outcome = walk_block(block);
      if (outcome > 0)
        return RayHit{true, std::min(1.0, std::max(0.0, t_)), voxel_, {axis_, axis_ < 0 ? 0 : step_[axis_]}};
      is_inside = outcome == 0;
    }
    if (!is_certain_) return std::nullopt;
    return RayHit{};
  }

 private:
  /// Returns the ray parameter at the lower face of voxel index `plane` along axis `a`.
  double parameter(int a, int plane) const noexcept { return ((plane - 0.5) - start_[a]) * inverse_[a]; }

  /// Moves to the voxel behind the lower face of voxel index `plane` along `axis`, which the ray crosses at
  /// t; false if that voxel is outside the grid.
  bool move_past(int axis, int plane, double t) noexcept {
    t_ = t;
    axis_ = axis;
    for (int b = 0; b < 3; ++b) {
      if (b == axis || step_[b] == 0) continue;  // without motion along b the index stays exact
      const double p = start_[b] + t * direction_[b] + 0.5;
      const int k = static_cast<int>(p);  // equals floor(p), except for a negative p, which is outside
      const double part = p - k;
      is_certain_ = is_certain_ && part > k_plane_margin && part < 1 - k_plane_margin;
      if (p < 0 || k >= size_[b]) return false;
      voxel_[b] = k;
    }
    voxel_[axis] = step_[axis] > 0 ? plane : plane - 1;
    return voxel_[axis] >= 0 && voxel_[axis] < size_[axis];
  }

  /// Moves to the first voxel inside the grid; false if there is no such voxel.
  bool enter() noexcept {
    voxel_ = voxel_of(start_);
    const bool is_in = voxel_.x >= 0 && voxel_.y >= 0 && voxel_.z >= 0 && voxel_.x < size_.x &&
                       voxel_.y < size_.y && voxel_.z < size_.z;
    if (is_in) return true;
    int axis = -1, plane = 0;
    double t = 0;
    for (int a = 0; a < 3; ++a) {
      if (voxel_[a] >= 0 && voxel_[a] < size_[a]) continue;
      if (step_[a] == 0 || (voxel_[a] < 0) != (step_[a] > 0)) return false;
      const int edge = voxel_[a] < 0 ? 0 : size_[a];
      const double t_edge = parameter(a, edge);
      if (axis < 0 || t_edge > t) axis = a, plane = edge, t = t_edge;
    }
    is_certain_ = is_certain_ && std::abs(t - 1) > k_tie_margin;
    return t < 1 && move_past(axis, plane, t);
  }

  /// Leaves the empty voxels low .. high - 1; false if the ray ends first or leaves the grid.
  bool leave(const ivec3& low, const ivec3& high) noexcept {
    int axis = -1, plane = 0;
    double t = 2;
    for (int a = 0; a < 3; ++a) {
      if (step_[a] == 0) continue;
      const int edge = step_[a] > 0 ? high[a] : low[a];
      const double t_edge = parameter(a, edge);
      if (t_edge < t) axis = a, plane = edge, t = t_edge;
    }
    is_certain_ = is_certain_ && std::abs(t - 1) > k_tie_margin;
    return t < 1 && move_past(axis, plane, t);
  }

  /// Visits the voxels of one block. Returns 1 at a solid voxel, 0 after leaving the block, -1 if the ray
  /// ends, leaves the grid, or is uncertain.
  int walk_block(const ivec3& block) noexcept {
    double next[3];
    for (int a = 0; a < 3; ++a) next[a] = step_[a] != 0 ? parameter(a, voxel_[a] + (step_[a] > 0)) : 1e300;
    while (true) {
      if (bits_.is_solid(voxel_) && (version_ == nullptr || version_->is_kept(voxel_))) return 1;
      const int a = next[0] < next[1] ? (next[0] < next[2] ? 0 : 2) : (next[1] < next[2] ? 1 : 2);
      const double t = next[a];
      // Uncertain if two faces are crossed at nearly the same parameter, or one at the ray's end.
      const int b = a == 2 ? 0 : a + 1, c = a == 0 ? 2 : a - 1;
      is_certain_ = is_certain_ && next[b] - t > k_tie_margin && next[c] - t > k_tie_margin &&
                    std::abs(t - 1) > k_tie_margin;
      if (!is_certain_ || t >= 1) return -1;
      voxel_[a] += step_[a];
      t_ = t;
      axis_ = a;
      if (voxel_[a] < 0 || voxel_[a] >= size_[a]) return -1;  // possible in a block at the grid's border
      if (voxel_[a] >> 2 != block[a]) return 0;
      next[a] = parameter(a, voxel_[a] + (step_[a] > 0));
    }
  }

  ivec3 size_;
  const Occupancy& bits_;
  const Version* version_;
  dvec3 start_, direction_, inverse_;
  ivec3 step_, voxel_{0};
  double t_ = 0;
  int axis_ = -1;
  bool is_certain_ = true;
};

}  // namespace

RayHit first_hit(const Occupancy& bits, const Ray& ray, const Version* version) noexcept {
  for (const dvec3* p : {&ray.start, &ray.end})
    for (int a = 0; a < 3; ++a)
      if (!(std::abs((*p)[a]) < k_traversal_limit)) return {};
  if (const auto hit = PlainWalk(bits, ray, version).run()) return *hit;
  return walk_exactly(bits, ray, version);
}

void first_hits(const Occupancy& bits, std::span<const Ray> rays, std::span<RayHit> hits,
                const Version* version, int threads) {
  const int batches = static_cast<int>((rays.size() + k_rays_per_batch - 1) / k_rays_per_batch);
  parallel_for(batches, threads, [&](int batch) {
    const std::size_t begin = static_cast<std::size_t>(batch) * k_rays_per_batch;
    for (std::size_t i = begin; i < std::min(rays.size(), begin + k_rays_per_batch); ++i)
      hits[i] = first_hit(bits, rays[i], version);
  });
}

}  // namespace trephine::volume
