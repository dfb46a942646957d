#include "volume/cuts/operated_volume.h"

#include <algorithm>
#include <cmath>

#include "volume/base/parallel.h"

namespace trephine::volume {

namespace {

/// Calls visit(voxel, removed share) for each voxel of the box with removed matter.
template <class Visit>
void each_cut(const Version& version, const VoxelBox& box, Visit&& visit) {
  for (int z = box.low.z; z <= box.high.z; ++z)
    for (int y = box.low.y; y <= box.high.y; ++y)
      for (int x = box.low.x; x <= box.high.x; ++x) {
        if (x % 64 == 0 && !version.has_brick(version.lattice().low_of({x, y, z}),
                                              version.lattice().high_of({x + 63, y, z}))) {
          x += 63;
          continue;
        }
        const double share = version.removed_share({x, y, z});
        if (share > 0) visit(glm::ivec3(x, y, z), share);
      }
}

std::int16_t operated(std::int16_t value, double share, double air) noexcept {
  return static_cast<std::int16_t>(std::floor(value + share * (air - value) + 0.5));
}

}  // namespace

double air_of(const Volume& base) {
  return base.is_hounsfield ? -1000 : *std::min_element(base.voxels.span().begin(), base.voxels.span().end());
}

void read_operated(const Version& version, const VoxelBox& box, double air, std::int16_t* intensities) {
  const Volume& base = version.base();
  const glm::ivec3 size = box.high - box.low + 1;
  const auto row_at = [&](int y, int z) {
    return intensities + static_cast<std::size_t>(size.x) *
                             (static_cast<std::size_t>(y - box.low.y) +
                              static_cast<std::size_t>(size.y) * static_cast<std::size_t>(z - box.low.z));
  };
  for (int z = box.low.z; z <= box.high.z; ++z)
    for (int y = box.low.y; y <= box.high.y; ++y)
      std::copy_n(base.voxels.data() + base.index(box.low.x, y, z), size.x, row_at(y, z));
  each_cut(version, box, [&](const glm::ivec3& v, double share) {
    std::int16_t& value = row_at(v.y, v.z)[v.x - box.low.x];
    value = operated(value, share, air);
  });
}

Result<Volume> operated_volume(const Version& version) {
  const Volume& base = version.base();
  Result<Volume> output = copy_of(base);
  if (!output) return output;
  Volume& result = output.value();
  const double air = air_of(base);
  parallel_for(base.size.z, 0, [&](int z) {
    each_cut(version, {{0, 0, z}, {base.size.x - 1, base.size.y - 1, z}},
             [&](const glm::ivec3& v, double share) {
               const std::size_t i = base.index(v.x, v.y, v.z);
               result.voxels[i] = operated(base.voxels[i], share, air);
               if (share == 1 && !result.labels.is_empty()) result.labels[i] = 0;
             });
  });
  return output;
}

}  // namespace trephine::volume
