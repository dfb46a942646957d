#include "modules/ct_viewer/slice_image.h"

#include <algorithm>
#include <cmath>

#include "volume/cuts/operated_volume.h"

namespace trephine::ct_viewer {

namespace {

/// Samples a slab as scanned and as operated, in the same layers as volume::reslice().
SliceValues sample_layers(const volume::Volume& scan, const volume::Version& version,
                          volume::ImagePlane plane, const volume::Slab& slab, std::int16_t air, int threads) {
  const glm::dvec3 spacing = scan.frame.spacing(), middle = plane.middle_world, normal = plane.normal();
  const double least = std::min({spacing.x, spacing.y, spacing.z});
  const int layers = 1 + static_cast<int>(std::ceil(2 * slab.thickness / least));
  const std::size_t count = static_cast<std::size_t>(plane.columns) * static_cast<std::size_t>(plane.rows);
  const bool is_mean = slab.kind == volume::Slab::Kind::mean;
  std::vector<double> value_before(count, 0), value_now(count, 0);
  std::vector<int> samples(count, 0);
  SliceValues result{std::vector<std::int16_t>(count), {}};
  for (int layer = 0; layer < layers; ++layer) {
    plane.middle_world = middle + slab.thickness * (layer / (layers - 1.0) - 0.5) * normal;
    volume::reslice(scan, plane, {}, k_outside, threads, result.before);
    result.now = result.before;
    volume::reslice_cuts(version, plane, air, threads, result.now);
    for (std::size_t i = 0; i < count; ++i) {
      if (result.before[i] == k_outside) continue;
      const bool is_first = samples[i]++ == 0;
      value_before[i] = is_mean    ? value_before[i] + result.before[i]
                        : is_first ? result.before[i]
                                   : std::max<double>(value_before[i], result.before[i]);
      value_now[i] = is_mean    ? value_now[i] + result.now[i]
                     : is_first ? result.now[i]
                                : std::max<double>(value_now[i], result.now[i]);
    }
  }
  for (std::size_t i = 0; i < count; ++i) {
    const double parts = is_mean ? std::max(1, samples[i]) : 1;
    const auto rounded = [&](double v) {
      return samples[i] > 0 ? static_cast<std::int16_t>(std::lround(v / parts)) : k_outside;
    };
    result.before[i] = rounded(value_before[i]), result.now[i] = rounded(value_now[i]);
  }
  return result;
}

}  // namespace

SliceValues slice_values(const volume::Volume& scan, const volume::Version& version,
                         const volume::ImagePlane& plane, const volume::Slab& slab, int threads) {
  const auto air = static_cast<std::int16_t>(volume::air_of(scan));
  if (slab.thickness > 0 && !version.is_uncut())
    return sample_layers(scan, version, plane, slab, air, threads);
  SliceValues values;
  values.before.resize(static_cast<std::size_t>(plane.columns) * static_cast<std::size_t>(plane.rows));
  volume::reslice(scan, plane, slab, k_outside, threads, values.before);
  values.now = values.before;
  volume::reslice_cuts(version, plane, air, threads, values.now);
  return values;
}

Pixel pixel_of(std::int16_t before, std::int16_t now, const GreyWindow& window, Blend blend) noexcept {
  if (before == k_outside) return {14, 14, 14};
  const std::uint8_t grey_before = window.grey(before), grey_now = window.grey(now);
  if (blend == Blend::before) return {grey_before, grey_before, grey_before};
  if (blend == Blend::now || before == now) return {grey_now, grey_now, grey_now};
  const auto amber = [](double share) { return static_cast<std::uint8_t>(share + 0.5); };
  return {amber(60 + 0.76 * grey_before), amber(28 + 0.52 * grey_before), amber(0.15 * grey_before)};
}

}  // namespace trephine::ct_viewer
