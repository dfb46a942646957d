#include "apps/verify/fall_through.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <utility>

#include "apps/verify/exact_traversal.h"

namespace trephine::verify {

namespace {
bool is_in_grid(const glm::ivec3& size, int x, int y, int z) {
  return x >= 0 && y >= 0 && z >= 0 && x < size.x && y < size.y && z < size.z;
}
std::array<double, 3> to_array(const glm::dvec3& p) { return {p.x, p.y, p.z}; }
}  // namespace

FallThroughJudge::FallThroughJudge(const glm::ivec3& size, SolidVoxels solid)
    : meets_solid_([size, solid = std::move(solid)](const glm::dvec3& a, const glm::dvec3& b) {
        for (const ExactVisit& v :
             exact_traversal(to_array(a), to_array(b), {0, 0, 0}, {size.x - 1, size.y - 1, size.z - 1}))
          if (solid(v.voxel[0], v.voxel[1], v.voxel[2])) return true;
        return false;
      }) {}

void FallThroughJudge::judge_step(const StepUnderJudgement& step) {
  ++steps_;
  judged_ += has_last_ && !is_inside_;
  const glm::dvec3 proxy = step.path_volume.back();
  const bool may_have_grown = std::exchange(has_changed_, false);
  if (step.is_buried || !has_last_) {
    if (step.is_buried) {
      ++buried_starts_;
      // A proxy that was already inside matter cannot fall.
      if (has_last_ && !is_inside_ && !(may_have_grown && meets_solid_(last_, last_))) ++fall_throughs_;
    }
    last_ = proxy;
    has_last_ = true;
    is_inside_ = meets_solid_(proxy, proxy);  // a proxy that begins inside matter cannot fall
    return;
  }
  if (is_inside_) {
    is_inside_ = meets_solid_(proxy, proxy);
    last_ = proxy;
    return;
  }
  bool fell = step.path_volume.front() != last_;  // a path that does not begin at the last proxy is a jump
  if (step.path_volume.size() == 1) fell = fell || meets_solid_(proxy, proxy);
  for (std::size_t i = 1; i < step.path_volume.size(); ++i)
    fell = fell || meets_solid_(step.path_volume[i - 1], step.path_volume[i]);
  // Without contact the proxy is at the HIP. The tolerance allows for rounding in conversions
  // between frames.
  if (!step.has_contact)
    fell = fell || glm::length(proxy - step.hip_volume) > 1e-12 * (1 + glm::length(step.hip_volume));
  if (fell) {
    ++fall_throughs_;
    is_inside_ = meets_solid_(proxy, proxy);
  }
  last_ = proxy;
}

glm::dvec3 resting_point_on_cubes(const glm::ivec3& size, const SolidVoxels& solid, const glm::dvec3 axes[3],
                                  const glm::dvec3& proxy, const glm::dvec3& hip) {
  const auto energy = [&](const glm::dvec3& p) {
    const glm::dvec3 d = hip - p;
    const glm::dvec3 w = axes[0] * d.x + axes[1] * d.y + axes[2] * d.z;
    return w.x * w.x + w.y * w.y + w.z * w.z;
  };
  // Returns the point of a cube nearest to the HIP, by coordinate descent (exact for orthogonal axes).
  const auto nearest_in = [&](const glm::ivec3& v) {
    glm::dvec3 p(std::clamp(hip.x, v.x - 0.5, v.x + 0.5), std::clamp(hip.y, v.y - 0.5, v.y + 0.5),
                 std::clamp(hip.z, v.z - 0.5, v.z + 0.5));
    for (int round = 0; round < 20; ++round)
      for (int a = 0; a < 3; ++a) {
        glm::dvec3 difference = hip - p;
        difference[a] = 0;
        double along = 0, square = 0;
        for (int k = 0; k < 3; ++k) {
          const double rest =
              axes[0][k] * difference.x + axes[1][k] * difference.y + axes[2][k] * difference.z;
          along += rest * axes[a][k];
          square += axes[a][k] * axes[a][k];
        }
        p[a] = std::clamp(hip[a] + along / square, v[a] - 0.5, v[a] + 0.5);
      }
    return p;
  };
  const auto is_free = [&](const glm::ivec3& v) {
    return !is_in_grid(size, v.x, v.y, v.z) || !solid(v.x, v.y, v.z);
  };
  glm::ivec3 at(static_cast<int>(std::floor(proxy.x + 0.5)), static_cast<int>(std::floor(proxy.y + 0.5)),
                static_cast<int>(std::floor(proxy.z + 0.5)));
  glm::dvec3 best = nearest_in(at);
  for (int moves = 0; moves < 1000; ++moves) {
    bool is_better = false;
    for (int a = 0; a < 3 && !is_better; ++a)
      for (int s = -1; s <= 1; s += 2) {
        if (std::abs(best[a] - (at[a] + 0.5 * s)) > 1e-9) continue;  // not on that face
        glm::ivec3 next = at;
        next[a] += s;
        if (!is_free(next)) continue;
        const glm::dvec3 p = nearest_in(next);
        if (energy(p) < energy(best) - 1e-12) {
          at = next;
          best = p;
          is_better = true;
          break;
        }
      }
    if (!is_better) break;
  }
  return best;
}

}  // namespace trephine::verify
