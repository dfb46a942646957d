// Image of a plane through a scan: before, after, or one over the other.
#pragma once

#include <limits>
#include <vector>

#include "modules/ct_viewer/grey_window.h"
#include "volume/reslice.h"

namespace trephine::ct_viewer {

/// Beyond the scan.
inline constexpr std::int16_t k_outside = std::numeric_limits<std::int16_t>::min();

/// Intensities of a plane or a slab, row by row from the upper left.
struct SliceValues {
  std::vector<std::int16_t> before, now;  ///< as it was scanned; with what was cut away as air
};
/// `version`: of the volume, frozen or not. What was cut is looked at in every layer of a slab; where nothing
/// was, both are the same.
SliceValues slice_values(const volume::Volume& scan, const volume::Version& version,
                         const volume::ImagePlane& plane, const volume::Slab& slab, int threads = 0);

/// Parts of both states that are shown.
enum class Blend : std::uint8_t { now, before, both };
inline constexpr std::string_view k_blends[] = {"now", "before", "both"};
/// With `both`, removed matter is shown as it was, in amber.
struct Pixel {
  std::uint8_t red, green, blue;
};
Pixel pixel_of(std::int16_t before, std::int16_t now, const GreyWindow& window, Blend blend) noexcept;

}  // namespace trephine::ct_viewer
