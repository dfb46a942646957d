#include "volume/operated_volume.h"

#include <algorithm>
#include <cmath>

#include "volume/parallel.h"

namespace trephine::volume {

Result<Volume> operated_volume(const Version& version) {
  const Volume& base = version.base();
  Result<Volume> made = make_volume(base.size, base.frame, !base.labels.is_empty());
  if (!made) return made;
  Volume& result = made.value();
  result.is_hounsfield = base.is_hounsfield;
  result.label_names = base.label_names;
  std::copy_n(base.voxels.data(), base.voxels.size(), result.voxels.data());
  std::copy_n(base.labels.data(), base.labels.size(), result.labels.data());
  const double air =
      base.is_hounsfield ? -1000 : *std::min_element(base.voxels.span().begin(), base.voxels.span().end());
  parallel_for(base.size.z, 0, [&](int z) {
    for (int y = 0; y < base.size.y; ++y)
      for (int x = 0; x < base.size.x; ++x) {
        if (x % 64 == 0 && !version.has_brick(version.lattice().low_of({x, y, z}),
                                              version.lattice().high_of({x + 63, y, z}))) {
          x += 63;
          continue;
        }
        const double share = version.removed_share({x, y, z});
        if (share == 0) continue;
        const std::size_t i = base.index(x, y, z);
        result.voxels[i] =
            static_cast<std::int16_t>(std::floor(base.voxels[i] + share * (air - base.voxels[i]) + 0.5));
        if (share == 1 && !result.labels.is_empty()) result.labels[i] = 0;
      }
  });
  return made;
}

}  // namespace trephine::volume
