#include "volume/rays.h"

#include <cmath>
#include <optional>

#include "volume/parallel.h"
#include "volume/version.h"

namespace trephine::volume {

using glm::dvec3;
using glm::ivec3;

namespace {

constexpr double k_doubt = 1e-9;     // voxels: nearer to a lattice plane, rounding may say another voxel
constexpr double k_gap = 1e-12;      // of the ray: planes that are met closer to each other come in any order
constexpr double k_far = 1 << 20;    // voxels: beyond, coordinates are too coarse for that
constexpr int k_rays_a_turn = 4096;  // handed to a thread at once

/// Every voxel or empty box in turn, in exact order.
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

/// Variant in plain arithmetic. It knows where it may be wrong, which is nearly nowhere, and gives up there.
class PlainWalk {
 public:
  PlainWalk(const Occupancy& bits, const Ray& ray, const Version* version) noexcept
      : size_(bits.size()), bits_(bits), version_(version), start_(ray.start), way_(ray.end - ray.start) {
    for (int a = 0; a < 3; ++a) {
      step_[a] = way_[a] > 0 ? 1 : way_[a] < 0 ? -1 : 0;
      inverse_[a] = step_[a] != 0 ? 1 / way_[a] : 0;
      is_sure_ = is_sure_ && std::abs(start_[a]) < k_far && std::abs(start_[a] + way_[a]) < k_far;
    }
  }

  /// The answer; nothing when it might be wrong.
  std::optional<RayHit> run() noexcept {
    if (!is_sure_) return std::nullopt;
    bool is_going = enter();
    while (is_going && is_sure_) {
      const int far = bits_.empty_distance(voxel_);
      const ivec3 block(voxel_.x >> 2, voxel_.y >> 2, voxel_.z >> 2);
      if (far > 0) {
        is_going = leave(4 * (block - (far - 1)), 4 * (block + far));
        continue;
      }
      const int found = walk_block(block);
      if (found > 0)
        return RayHit{true, std::min(1.0, std::max(0.0, t_)), voxel_, {axis_, axis_ < 0 ? 0 : step_[axis_]}};
      is_going = found == 0;
    }
    if (!is_sure_) return std::nullopt;
    return RayHit{};
  }

 private:
  /// Crossing of the lower face of voxel `plane`.
  double parameter(int a, int plane) const noexcept { return ((plane - 0.5) - start_[a]) * inverse_[a]; }

  /// To the voxel after `plane` of `axis`; false when it is outside.
  bool go(int axis, int plane, double t) noexcept {
    t_ = t;
    axis_ = axis;
    for (int b = 0; b < 3; ++b) {
      if (b == axis || step_[b] == 0) continue;  // not along b: where it began, to the last bit
      const double p = start_[b] + t * way_[b] + 0.5;
      const int k = static_cast<int>(p);  // not negative, or outside
      const double part = p - k;
      is_sure_ = is_sure_ && part > k_doubt && part < 1 - k_doubt;
      if (p < 0 || k >= size_[b]) return false;
      voxel_[b] = k;
    }
    voxel_[axis] = step_[axis] > 0 ? plane : plane - 1;
    return voxel_[axis] >= 0 && voxel_[axis] < size_[axis];
  }

  /// The first voxel inside the grid.
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
      const double here = parameter(a, edge);
      if (axis < 0 || here > t) axis = a, plane = edge, t = here;
    }
    is_sure_ = is_sure_ && std::abs(t - 1) > k_gap;
    return t < 1 && go(axis, plane, t);
  }

  /// Out of the empty voxels low .. high - 1; false when the ray ends first or leaves the grid.
  bool leave(const ivec3& low, const ivec3& high) noexcept {
    int axis = -1, plane = 0;
    double t = 2;
    for (int a = 0; a < 3; ++a) {
      if (step_[a] == 0) continue;
      const int edge = step_[a] > 0 ? high[a] : low[a];
      const double here = parameter(a, edge);
      if (here < t) axis = a, plane = edge, t = here;
    }
    is_sure_ = is_sure_ && std::abs(t - 1) > k_gap;
    return t < 1 && go(axis, plane, t);
  }

  /// Voxel by voxel through one block. 1: this voxel is solid, 0: left it, -1: the ray ended.
  int walk_block(const ivec3& block) noexcept {
    double next[3];
    for (int a = 0; a < 3; ++a) next[a] = step_[a] != 0 ? parameter(a, voxel_[a] + (step_[a] > 0)) : 1e300;
    while (true) {
      if (bits_.is_solid(voxel_) && (version_ == nullptr || version_->is_kept(voxel_))) return 1;
      const int a = next[0] < next[1] ? (next[0] < next[2] ? 0 : 2) : (next[1] < next[2] ? 1 : 2);
      const double t = next[a];
      // Two planes at once, or one at the ray's end: in doubt.
      const int b = a == 2 ? 0 : a + 1, c = a == 0 ? 2 : a - 1;
      is_sure_ = is_sure_ && next[b] - t > k_gap && next[c] - t > k_gap && std::abs(t - 1) > k_gap;
      if (!is_sure_ || t >= 1) return -1;
      voxel_[a] += step_[a];
      t_ = t;
      axis_ = a;
      if (voxel_[a] < 0 || voxel_[a] >= size_[a]) return -1;  // also within a block that the grid cuts
      if (voxel_[a] >> 2 != block[a]) return 0;
      next[a] = parameter(a, voxel_[a] + (step_[a] > 0));
    }
  }

  ivec3 size_;
  const Occupancy& bits_;
  const Version* version_;
  dvec3 start_, way_, inverse_;
  ivec3 step_, voxel_{0};
  double t_ = 0;
  int axis_ = -1;
  bool is_sure_ = true;
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
  const int turns = static_cast<int>((rays.size() + k_rays_a_turn - 1) / k_rays_a_turn);
  parallel_for(turns, threads, [&](int turn) {
    const std::size_t begin = static_cast<std::size_t>(turn) * k_rays_a_turn;
    for (std::size_t i = begin; i < std::min(rays.size(), begin + k_rays_a_turn); ++i)
      hits[i] = first_hit(bits, rays[i], version);
  });
}

}  // namespace trephine::volume
