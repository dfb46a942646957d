// From what rays are weakened by to what a detector shows.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "modules/fluoroscopy/c_arm.h"

namespace trephine::fluoroscopy {

struct Detector {
  double photons = 0;      ///< that a pixel meets where nothing is in the beam; 0: endless, no noise
  double blur = 0;         ///< sigma of a Gaussian, pixels
  std::uint64_t seed = 1;  ///< of the noise
};

/// Signal of each pixel, 1: all that was sent. `sums`: of `view` refined so many times; a pixel receives
/// the mean of its rays. Closed pixels 0. The same bits for any number of threads.
std::vector<float> receive(std::span<const double> sums, const View& view, int rays_a_pixel_edge,
                           const Detector& detector, int threads = 0);

struct Display {
  bool is_logarithmic = true;  ///< else linear in what is received
  bool is_inverted = false;    ///< bone bright, as on a film; else where radiation comes through
  double low_share = 0.03,
         high_share = 0.995;  ///< of pixels with something in the beam: greys are spread between
};
/// One byte a pixel. `hidden`: pixels that are shown as closed ones are; may be empty.
std::vector<std::uint8_t> show(std::span<const float> received, const View& view, const Display& display,
                               std::span<const std::uint8_t> hidden);
/// -ln of what is received, which log displays and DICOM's LOG pixels are made of; at most 15.99.
double weakening(float received) noexcept;

}  // namespace trephine::fluoroscopy
