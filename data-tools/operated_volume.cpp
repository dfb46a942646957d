#include "data-tools/operated_volume.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "volume/parallel.h"

namespace trephine::data_tools {

using volume::Volume;

volume::Result<Volume> operated_volume(const volume::Version& version) {
  const Volume& base = version.base();
  volume::Result<Volume> made = volume::make_volume(base.size, base.frame, !base.labels.is_empty());
  if (!made) return made;
  Volume& result = made.value();
  result.is_hounsfield = base.is_hounsfield;
  result.label_names = base.label_names;
  std::copy_n(base.voxels.data(), base.voxels.size(), result.voxels.data());
  std::copy_n(base.labels.data(), base.labels.size(), result.labels.data());
  const double air =
      base.is_hounsfield ? -1000 : *std::min_element(base.voxels.span().begin(), base.voxels.span().end());
  volume::parallel_for(base.size.z, 0, [&](int z) {
    for (int y = 0; y < base.size.y; ++y)
      for (int x = 0; x < base.size.x; ++x) {
        const volume::Brick* brick = version.brick_at(x, y, z);
        if (brick == nullptr || !brick->mask) continue;
        const volume::RemovalMask& mask = *brick->mask;
        const auto words = static_cast<std::size_t>(mask.words_per_voxel());
        const std::uint64_t* at = mask.words.data() + words * volume::Brick::index(x & 7, y & 7, z & 7);
        int removed = 0;
        for (std::size_t w = 0; w < words; ++w) removed += std::popcount(at[w]);
        if (removed == 0) continue;
        const std::size_t i = base.index(x, y, z);
        const double share = static_cast<double>(removed) / (mask.n * mask.n * mask.n);
        result.voxels[i] =
            static_cast<std::int16_t>(std::floor(base.voxels[i] + share * (air - base.voxels[i]) + 0.5));
        if (share == 1 && !result.labels.is_empty()) result.labels[i] = 0;
      }
  });
  return made;
}

}  // namespace trephine::data_tools
