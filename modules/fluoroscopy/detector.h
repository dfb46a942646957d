// Detector: converts the attenuation of rays into signals and displayed grey values.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "modules/fluoroscopy/c_arm.h"

namespace trephine::fluoroscopy {

struct Detector {
  double photons = 0;      ///< per pixel in the open beam; 0: no noise
  double blur = 0;         ///< sigma of a Gaussian, pixels
  std::uint64_t seed = 1;  ///< seed of the noise
};

/// Returns the signal of each pixel, 1 in the open beam. `sums`: attenuation along the rays of
/// view.refined(rays_per_pixel_edge). A pixel receives the mean transmission of its rays. Closed pixels are
/// 0. Any number of threads gives the same bits.
std::vector<float> receive(std::span<const double> sums, const View& view, int rays_per_pixel_edge,
                           const Detector& detector, int threads = 0);

struct Display {
  bool is_logarithmic = true;  ///< false: linear in the signal
  bool is_inverted = false;    ///< bone is bright, as on film
  /// Quantiles (0 to 1) of the brightness of pixels with matter in the beam: `low_share` is shown black,
  /// `high_share` white (inverted: white, black).
  double low_share = 0.03, high_share = 0.995;
  /// Share of the mean brightness of the surround that is subtracted; logarithmic displays only. 0: none.
  double equalization = 0;
};
/// Display for people: bone is visible in thick and in thin parts of the body, but the grey of a pixel
/// depends on its surround.
inline constexpr Display k_fluoroscope_display{.low_share = 0.003, .equalization = 0.8};
/// Returns one byte per pixel. `hidden`: pixels that are shown like closed ones; may be empty.
std::vector<std::uint8_t> show(std::span<const float> received, const View& view, const Display& display,
                               std::span<const std::uint8_t> hidden);
/// Returns -ln of a signal, as used by logarithmic displays and DICOM's LOG pixels; at most 15.99.
double attenuation_of(float received) noexcept;

}  // namespace trephine::fluoroscopy
