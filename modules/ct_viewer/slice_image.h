// Image of a plane through a scan: as scanned, as operated, or a blend of both.
#pragma once

#include <limits>
#include <vector>

#include "modules/ct_viewer/grey_window.h"
#include "volume/imaging/reslice.h"

namespace trephine::ct_viewer {

/// Value of a pixel outside the scan.
inline constexpr std::int16_t k_outside = std::numeric_limits<std::int16_t>::min();

/// Intensities of a plane or a slab, row by row from the upper left.
struct SliceValues {
  std::vector<std::int16_t> before, now;  ///< as scanned; with removed matter as air
};
/// Samples the scan as scanned and as operated. `version`: version of the scan, frozen or not. Cuts are
/// sampled in every layer of a slab. Both images are equal where no matter was removed.
SliceValues slice_values(const volume::Volume& scan, const volume::Version& version,
                         const volume::ImagePlane& plane, const volume::Slab& slab, int threads = 0);

/// State that is shown.
enum class Blend : std::uint8_t { now, before, both };
inline constexpr std::string_view k_blends[] = {"now", "before", "both"};
/// Colour of a pixel. With `both`, removed matter has its scanned brightness, in amber.
struct Pixel {
  std::uint8_t red, green, blue;
};
Pixel pixel_of(std::int16_t before, std::int16_t now, const GreyWindow& window, Blend blend) noexcept;

}  // namespace trephine::ct_viewer
