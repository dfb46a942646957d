#include "volume/shape_choice.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <vector>

#include "volume/solid_parts.h"

namespace trephine::volume {

namespace {

ShapeParts summary_of(const SolidParts& parts, int& largest) {
  ShapeParts summary;
  summary.count = static_cast<int>(parts.parts().size());
  for (int p = 0; p < summary.count; ++p) {
    const std::int64_t samples = parts.parts()[static_cast<std::size_t>(p)].samples;
    if (samples > summary.largest) {
      summary.others += summary.largest;
      summary.second = summary.largest;
      summary.largest = samples;
      largest = p;
    } else {
      summary.others += samples;
      summary.second = std::max(summary.second, samples);
    }
  }
  return summary;
}

SolidParts find_parts(const std::shared_ptr<const Volume>& volume, const Shape& shape) {
  return {Field(*volume, shape), Occupancy::build(*volume, shape), Version(volume)};
}

}  // namespace

int otsu_threshold(const Volume& volume) {
  std::vector<std::int64_t> count(65536, 0);
  for (const std::int16_t v : volume.voxels.span()) ++count[static_cast<std::size_t>(v + 32768)];
  double all = 0, sum = 0;
  for (std::size_t i = 0; i < count.size(); ++i) {
    all += static_cast<double>(count[i]);
    sum += static_cast<double>(count[i]) * static_cast<double>(i);
  }
  double below = 0, sum_below = 0, best = -1;
  std::size_t at = 0, empty_from = 0;
  for (std::size_t i = 0; i + 1 < count.size(); ++i) {
    below += static_cast<double>(count[i]);
    sum_below += static_cast<double>(count[i]) * static_cast<double>(i);
    if (below == 0 || below == all) continue;
    const double difference = sum_below / below - (sum - sum_below) / (all - below);
    const double between = below * (all - below) * difference * difference;
    // Between two values that occur any threshold is as good: the middle.
    if (between > best)
      best = between, at = i + 1, empty_from = i + 1;
    else if (between == best && count[i] == 0)
      at = (empty_from + i + 1) / 2;
  }
  return static_cast<int>(at) - 32768;
}

ShapeParts parts_of(const std::shared_ptr<const Volume>& volume, const Shape& shape) {
  int largest = 0;
  return summary_of(find_parts(volume, shape), largest);
}

Result<Volume> with_largest_part(const std::shared_ptr<const Volume>& volume, const Shape& shape,
                                 ShapeParts& summary) {
  const SolidParts parts = find_parts(volume, shape);
  int largest = 0;
  summary = summary_of(parts, largest);
  if (summary.count == 0)
    return Error{"there is nothing of that shape", "",
                 "no voxel of " + describe(shape, volume->is_hounsfield), "some", "choose another shape"};
  Result<Volume> made = make_volume(volume->size, volume->frame, !volume->labels.is_empty());
  if (!made) return made.error();
  Volume& copy = made.value();
  copy.is_hounsfield = volume->is_hounsfield;
  copy.label_names = volume->label_names;
  std::memcpy(copy.voxels.data(), volume->voxels.data(), volume->voxels.bytes());
  if (!copy.labels.is_empty()) std::memcpy(copy.labels.data(), volume->labels.data(), volume->labels.bytes());
  const std::int16_t lowest = *std::min_element(volume->voxels.span().begin(), volume->voxels.span().end());
  const std::int16_t air = volume->is_hounsfield ? std::max<std::int16_t>(lowest, -1000) : lowest;
  const CutLattice lattice(*volume);
  std::vector<int> row(static_cast<std::size_t>(volume->size.x));
  for (int z = 0; z < volume->size.z; ++z)
    for (int y = 0; y < volume->size.y; ++y) {
      const glm::ivec3 sample = lattice.centre_of({0, y, z});  // one sample a voxel
      parts.row(sample.x, sample.y, sample.z, volume->size.x, row.data());
      const std::size_t first = volume->index(0, y, z);
      for (std::size_t x = 0; x < row.size(); ++x) {
        if (row[x] == SolidParts::k_air || row[x] == largest) continue;
        if (shape.is_label())
          copy.labels[first + x] = 0;
        else
          copy.voxels[first + x] = air;
      }
    }
  return made;
}

}  // namespace trephine::volume
