#include "modules/ct_viewer/slice_image.h"

#include <algorithm>
#include <cmath>

#include "volume/operated_volume.h"

namespace trephine::ct_viewer {

namespace {

/// Both through all of a slab, layer by layer as volume::reslice() lays them.
SliceValues layers_of(const volume::Volume& scan, const volume::Version& version, volume::ImagePlane plane,
                      const volume::Slab& slab, std::int16_t air, int threads) {
  const glm::dvec3 spacing = scan.frame.spacing(), middle = plane.middle_world, normal = plane.normal();
  const double least = std::min({spacing.x, spacing.y, spacing.z});
  const int layers = 1 + static_cast<int>(std::ceil(2 * slab.thickness / least));
  const std::size_t count = static_cast<std::size_t>(plane.columns) * static_cast<std::size_t>(plane.rows);
  const bool is_mean = slab.kind == volume::Slab::Kind::mean;
  std::vector<double> was(count, 0), is(count, 0);
  std::vector<int> counted(count, 0);
  SliceValues one{std::vector<std::int16_t>(count), {}};
  for (int layer = 0; layer < layers; ++layer) {
    plane.middle_world = middle + slab.thickness * (layer / (layers - 1.0) - 0.5) * normal;
    volume::reslice(scan, plane, {}, k_outside, threads, one.before);
    one.now = one.before;
    volume::reslice_cuts(version, plane, air, threads, one.now);
    for (std::size_t i = 0; i < count; ++i) {
      if (one.before[i] == k_outside) continue;
      const bool is_first = counted[i]++ == 0;
      was[i] = is_mean    ? was[i] + one.before[i]
               : is_first ? one.before[i]
                          : std::max<double>(was[i], one.before[i]);
      is[i] = is_mean ? is[i] + one.now[i] : is_first ? one.now[i] : std::max<double>(is[i], one.now[i]);
    }
  }
  for (std::size_t i = 0; i < count; ++i) {
    const double parts = is_mean ? std::max(1, counted[i]) : 1;
    const auto whole = [&](double v) {
      return counted[i] > 0 ? static_cast<std::int16_t>(std::lround(v / parts)) : k_outside;
    };
    one.before[i] = whole(was[i]), one.now[i] = whole(is[i]);
  }
  return one;
}

}  // namespace

SliceValues slice_values(const volume::Volume& scan, const volume::Version& version,
                         const volume::ImagePlane& plane, const volume::Slab& slab, int threads) {
  const auto air = static_cast<std::int16_t>(volume::air_of(scan));
  if (slab.thickness > 0 && !version.is_untouched())
    return layers_of(scan, version, plane, slab, air, threads);
  SliceValues values;
  values.before.resize(static_cast<std::size_t>(plane.columns) * static_cast<std::size_t>(plane.rows));
  volume::reslice(scan, plane, slab, k_outside, threads, values.before);
  values.now = values.before;
  volume::reslice_cuts(version, plane, air, threads, values.now);
  return values;
}

Pixel pixel_of(std::int16_t before, std::int16_t now, const GreyWindow& window, Blend blend) noexcept {
  if (before == k_outside) return {14, 14, 14};
  const std::uint8_t was = window.grey(before), is = window.grey(now);
  if (blend == Blend::before) return {was, was, was};
  if (blend == Blend::now || before == now) return {is, is, is};
  const auto amber = [](double share) { return static_cast<std::uint8_t>(share + 0.5); };
  return {amber(60 + 0.76 * was), amber(28 + 0.52 * was), amber(0.15 * was)};
}

}  // namespace trephine::ct_viewer
