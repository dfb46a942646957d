#include "modules/fluoroscopy/detector.h"

#include <algorithm>
#include <cmath>

#include "volume/deterministic_math.h"
#include "volume/parallel.h"

namespace trephine::fluoroscopy {

namespace {

constexpr double k_thin = 0.3;  // of what weakens more than most of the body
constexpr std::uint8_t k_closed_grey = 24;
constexpr float k_empty_beam = 0.85f;  // what passes where hardly anything is in the beam

/// Uniform in (0, 1), of a pixel's own.
double uniform(std::uint64_t seed, std::size_t pixel, std::uint64_t number) noexcept {
  const std::uint64_t bits = volume::hash_bits(volume::hash_bits(volume::hash_bits(seed) ^ pixel) ^ number);
  return (static_cast<double>(bits >> 11) + 0.5) * 0x1p-53;
}

/// A number of photons, where `mean` are expected.
double photons_met(double mean, std::uint64_t seed, std::size_t pixel) noexcept {
  if (mean > 50) {  // next to normal
    const double u = uniform(seed, pixel, 0), v = uniform(seed, pixel, 1);
    const double normal = std::sqrt(-2 * volume::deterministic_log(u)) *
                          volume::deterministic_cos(2 * 3.14159265358979323846 * v);
    return std::max(0.0, std::floor(mean + std::sqrt(mean) * normal + 0.5));
  }
  // By the gaps between them (Knuth).
  const double limit = volume::deterministic_exp(-mean);
  double product = 1;
  int count = -1;
  do {
    ++count;
    product *= uniform(seed, pixel, static_cast<std::uint64_t>(count));
  } while (product > limit);
  return count;
}

/// Transmission of such a sum.
double passing(double sum) noexcept { return volume::deterministic_exp(-std::min(sum, 690.0)); }

/// Along rows, then along columns, within the open pixels; beyond them the nearest goes on.
void blur(std::vector<float>& image, const View& view, double sigma, int threads) {
  const int reach = static_cast<int>(std::ceil(4 * sigma));
  std::vector<double> weights;
  double all = 0;
  for (int k = -reach; k <= reach; ++k) {
    weights.push_back(volume::deterministic_exp(-0.5 * k * k / (sigma * sigma)));
    all += weights.back();
  }
  const volume::PixelBox& open = view.open;
  std::vector<float> other = image;
  const auto at = [&](int column, int row) {
    return static_cast<std::size_t>(column) +
           static_cast<std::size_t>(view.columns) * static_cast<std::size_t>(row);
  };
  for (const bool is_along_rows : {true, false}) {
    const std::vector<float>& from = is_along_rows ? image : other;
    std::vector<float>& to = is_along_rows ? other : image;
    volume::parallel_for(open.row_high - open.row_low, threads, [&](int n) {
      const int row = open.row_low + n;
      for (int column = open.column_low; column < open.column_high; ++column) {
        double sum = 0;
        for (int k = -reach; k <= reach; ++k) {
          const int c =
              is_along_rows ? std::clamp(column + k, open.column_low, open.column_high - 1) : column;
          const int r = is_along_rows ? row : std::clamp(row + k, open.row_low, open.row_high - 1);
          sum += weights[static_cast<std::size_t>(k + reach)] * static_cast<double>(from[at(c, r)]);
        }
        to[at(column, row)] = static_cast<float>(sum / all);
      }
    });
  }
}

}  // namespace

std::vector<float> receive(std::span<const double> sums, const View& view, int rays_a_pixel_edge,
                           const Detector& detector, int threads) {
  const int n = rays_a_pixel_edge;
  std::vector<float> image(static_cast<std::size_t>(view.columns) * static_cast<std::size_t>(view.rows), 0);
  const volume::PixelBox& open = view.open;
  const auto across = static_cast<std::size_t>(view.columns);
  volume::parallel_for(open.row_high - open.row_low, threads, [&](int i) {
    const int row = open.row_low + i;
    for (int column = open.column_low; column < open.column_high; ++column) {
      double mean = 0;
      for (int y = 0; y < n; ++y)
        for (int x = 0; x < n; ++x)
          mean += passing(sums[static_cast<std::size_t>(n * column + x) +
                               static_cast<std::size_t>(n) * across * static_cast<std::size_t>(n * row + y)]);
      image[static_cast<std::size_t>(column) + across * static_cast<std::size_t>(row)] =
          static_cast<float>(mean / (n * n));
    }
  });
  if (detector.blur > 0) blur(image, view, detector.blur, threads);
  if (detector.photons > 0)
    volume::parallel_for(open.row_high - open.row_low, threads, [&](int i) {
      const int row = open.row_low + i;
      for (int column = open.column_low; column < open.column_high; ++column) {
        const std::size_t pixel = static_cast<std::size_t>(column) + across * static_cast<std::size_t>(row);
        image[pixel] = static_cast<float>(
            photons_met(static_cast<double>(image[pixel]) * detector.photons, detector.seed, pixel) /
            detector.photons);
      }
    });
  return image;
}

double weakening(float received) noexcept {
  return std::min(15.99, -volume::deterministic_log(std::max(1e-30, static_cast<double>(received))));
}

std::vector<std::uint8_t> show(std::span<const float> received, const View& view, const Display& display,
                               std::span<const std::uint8_t> hidden) {
  const auto is_open = [&](std::size_t pixel) {
    const int column = static_cast<int>(pixel % static_cast<std::size_t>(view.columns)),
              row = static_cast<int>(pixel / static_cast<std::size_t>(view.columns));
    return column >= view.open.column_low && column < view.open.column_high && row >= view.open.row_low &&
           row < view.open.row_high && (hidden.empty() || !hidden[pixel]);
  };
  // Bright is more radiation.
  const auto brightness = [&](std::size_t pixel) {
    return display.is_logarithmic ? -weakening(received[pixel]) : static_cast<double>(received[pixel]);
  };
  // Pixels with matter in the beam; the rest is bright anyway.
  std::vector<double> all, beside;
  for (std::size_t pixel = 0; pixel < received.size(); ++pixel)
    if (is_open(pixel)) (received[pixel] < k_empty_beam ? all : beside).push_back(brightness(pixel));
  if (all.size() < beside.size() / 20) all.insert(all.end(), beside.begin(), beside.end());
  std::vector<std::uint8_t> grey(received.size(), k_closed_grey);
  if (all.empty()) return grey;
  const auto percentile = [&](double share) {
    const auto at = all.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(all.size() - 1));
    std::nth_element(all.begin(), at, all.end());
    return *at;
  };
  if (display.is_logarithmic) {
    // The greys are the body's: what is much thinner than most of it would leave none for the rest.
    const double thin = k_thin * percentile(0.25);
    std::vector<double> body;
    for (const double b : all)
      if (b <= thin) body.push_back(b);
    if (body.size() > all.size() / 4) all = std::move(body);
  }
  const double low = percentile(display.low_share), high = percentile(display.high_share);
  for (std::size_t pixel = 0; pixel < received.size(); ++pixel) {
    if (!is_open(pixel)) continue;
    double share = high > low ? std::clamp((brightness(pixel) - low) / (high - low), 0.0, 1.0) : 1.0;
    if (display.is_inverted) share = 1 - share;
    grey[pixel] = static_cast<std::uint8_t>(std::lround(255 * share));
  }
  return grey;
}

}  // namespace trephine::fluoroscopy
