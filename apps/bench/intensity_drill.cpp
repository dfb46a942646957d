#include "apps/bench/intensity_drill.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/gtc/matrix_access.hpp>
#include <glm/matrix.hpp>

namespace trephine::bench {

namespace {
/// Calls each(index) for the voxels with centres in a ball, until it returns false.
template <class Each>
void for_ball(const volume::Volume& scan, const glm::dvec3& middle_world, double radius,
              Each&& each) noexcept {
  const glm::dvec3 middle = scan.frame.volume_from_world(middle_world);
  const glm::dmat3 inverse = glm::inverse(scan.frame.axes());
  glm::ivec3 low, high;
  for (int a = 0; a < 3; ++a) {
    const double reach = radius * glm::length(glm::row(inverse, a));
    low[a] = std::max(0, static_cast<int>(std::ceil(middle[a] - reach)));
    high[a] = std::min(scan.size[a] - 1, static_cast<int>(std::floor(middle[a] + reach)));
  }
  for (int z = low.z; z <= high.z; ++z)
    for (int y = low.y; y <= high.y; ++y)
      for (int x = low.x; x <= high.x; ++x)
        if (glm::length(scan.frame.world_from_volume({x, y, z}) - middle_world) <= radius &&
            !each(scan.index(x, y, z)))
          return;
}
}  // namespace

IntensityDrill::IntensityDrill(volume::Volume scan, double radius, double rate)
    : scan_(std::move(scan)), radius_(radius), rate_(rate) {}

void IntensityDrill::stay(const glm::dvec3& tip_world, double seconds) noexcept {
  for_ball(scan_, tip_world, radius_, [&](std::size_t at) {
    scan_.voxels[at] =
        static_cast<std::int16_t>(std::lround(std::max(k_air, scan_.voxels[at] - rate_ * seconds)));
    return true;
  });
}

FixedCountDrill::FixedCountDrill(volume::Volume scan, double radius, int max_voxels)
    : scan_(std::move(scan)), radius_(radius), max_voxels_(max_voxels) {}

void FixedCountDrill::tick(const glm::dvec3& tip_world, double threshold) noexcept {
  int remaining = max_voxels_;
  for_ball(scan_, tip_world, radius_, [&](std::size_t at) {
    if (scan_.voxels[at] < threshold) return true;
    scan_.voxels[at] = static_cast<std::int16_t>(IntensityDrill::k_air);
    return --remaining > 0;
  });
}

}  // namespace trephine::bench
