#include "sim/engine/field_samples.h"

#include <cmath>
#include <glm/common.hpp>
#include <limits>

namespace trephine::sim {

using glm::dvec3;
using glm::ivec3;

void add_samples(MixHash& hash, const volume::OffsetField& field, const volume::VoxelBox& box, int count) {
  const glm::uvec3 size(glm::max(box.high - box.low + 1, ivec3(1)));
  std::uint64_t random = 1;
  const auto random_below = [&random](unsigned limit) {
    random = random * 6364136223846793005u + 1442695040888963407u;
    return static_cast<int>((random >> 33) % limit);
  };
  for (int i = 0; i < count; ++i) {
    const int x = random_below(size.x), y = random_below(size.y), z = random_below(size.z);
    hash.add(field.at(box.low.x + x, box.low.y + y, box.low.z + z));
  }
}

volume::VoxelBox lattice_box(const volume::OffsetField& field, const volume::Frame& frame,
                             const volume::VoxelBox& cut) {
  dvec3 low(std::numeric_limits<double>::max()), high(std::numeric_limits<double>::lowest());
  for (int corner = 0; corner < 8; ++corner) {
    const dvec3 at(corner & 1 ? cut.high.x : cut.low.x, corner & 2 ? cut.high.y : cut.low.y,
                   corner & 4 ? cut.high.z : cut.low.z);
    const dvec3 p = field.frame().volume_from_world(frame.world_from_volume(at));
    low = glm::min(low, p), high = glm::max(high, p);
  }
  const double margin = std::ceil((field.radius_mm() + field.far_mm()) / field.step_mm());
  const ivec3 last = field.size() - 1;
  return {glm::clamp(ivec3(glm::floor(low - margin)), ivec3(0), last),
          glm::clamp(ivec3(glm::ceil(high + margin)), ivec3(0), last)};
}

}  // namespace trephine::sim
