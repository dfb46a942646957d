#include "modules/fluoroscopy/detector.h"

#include <algorithm>
#include <cmath>

#include "volume/base/deterministic_math.h"
#include "volume/base/parallel.h"

namespace trephine::fluoroscopy {

namespace {

constexpr double k_thin =
    0.3;  // share of the attenuation at the upper quartile; pixels with less are outside the body
constexpr std::uint8_t k_closed_grey = 24;
constexpr float k_empty_beam = 0.85f;  // signal of an almost empty beam

/// Returns a pixel's random number, uniform in (0, 1).
double uniform(std::uint64_t seed, std::size_t pixel, std::uint64_t number) noexcept {
  const std::uint64_t bits = hash_bits(hash_bits(hash_bits(seed) ^ pixel) ^ number);
  return (static_cast<double>(bits >> 11) + 0.5) * 0x1p-53;
}

/// Returns a random number of photons with this mean (Poisson).
double photon_count(double mean, std::uint64_t seed, std::size_t pixel) noexcept {
  if (mean > 50) {  // nearly normal
    const double u = uniform(seed, pixel, 0), v = uniform(seed, pixel, 1);
    const double normal =
        std::sqrt(-2 * deterministic_log(u)) * deterministic_cos(2 * 3.14159265358979323846 * v);
    return std::max(0.0, std::floor(mean + std::sqrt(mean) * normal + 0.5));
  }
  // Poisson by a product of uniform numbers (Knuth).
  const double limit = deterministic_exp(-mean);
  double product = 1;
  int count = -1;
  do {
    ++count;
    product *= uniform(seed, pixel, static_cast<std::uint64_t>(count));
  } while (product > limit);
  return count;
}

/// Returns the transmission for an attenuation.
double transmission(double sum) noexcept { return deterministic_exp(-std::min(sum, 690.0)); }

/// Blurs along rows, then along columns, within the open pixels; border pixels are repeated beyond them.
void blur(std::vector<float>& image, const View& view, double sigma, int threads) {
  const int reach = static_cast<int>(std::ceil(4 * sigma));
  std::vector<double> weights;
  double total = 0;
  for (int k = -reach; k <= reach; ++k) {
    weights.push_back(deterministic_exp(-0.5 * k * k / (sigma * sigma)));
    total += weights.back();
  }
  const volume::PixelBox& open = view.open;
  std::vector<float> scratch = image;
  const auto at = [&](int column, int row) {
    return static_cast<std::size_t>(column) +
           static_cast<std::size_t>(view.columns) * static_cast<std::size_t>(row);
  };
  for (const bool is_along_rows : {true, false}) {
    const std::vector<float>& from = is_along_rows ? image : scratch;
    std::vector<float>& to = is_along_rows ? scratch : image;
    parallel_for(open.row_high - open.row_low, threads, [&](int n) {
      const int row = open.row_low + n;
      for (int column = open.column_low; column < open.column_high; ++column) {
        double sum = 0;
        for (int k = -reach; k <= reach; ++k) {
          const int c =
              is_along_rows ? std::clamp(column + k, open.column_low, open.column_high - 1) : column;
          const int r = is_along_rows ? row : std::clamp(row + k, open.row_low, open.row_high - 1);
          sum += weights[static_cast<std::size_t>(k + reach)] * static_cast<double>(from[at(c, r)]);
        }
        to[at(column, row)] = static_cast<float>(sum / total);
      }
    });
  }
}

}  // namespace

std::vector<float> receive(std::span<const double> sums, const View& view, int rays_per_pixel_edge,
                           const Detector& detector, int threads) {
  const int n = rays_per_pixel_edge;
  std::vector<float> image(static_cast<std::size_t>(view.columns) * static_cast<std::size_t>(view.rows), 0);
  const volume::PixelBox& open = view.open;
  const auto across = static_cast<std::size_t>(view.columns);
  parallel_for(open.row_high - open.row_low, threads, [&](int i) {
    const int row = open.row_low + i;
    for (int column = open.column_low; column < open.column_high; ++column) {
      double mean = 0;
      for (int y = 0; y < n; ++y)
        for (int x = 0; x < n; ++x)
          mean += transmission(
              sums[static_cast<std::size_t>(n * column + x) +
                   static_cast<std::size_t>(n) * across * static_cast<std::size_t>(n * row + y)]);
      image[static_cast<std::size_t>(column) + across * static_cast<std::size_t>(row)] =
          static_cast<float>(mean / (n * n));
    }
  });
  if (detector.blur > 0) blur(image, view, detector.blur, threads);
  if (detector.photons > 0)
    parallel_for(open.row_high - open.row_low, threads, [&](int i) {
      const int row = open.row_low + i;
      for (int column = open.column_low; column < open.column_high; ++column) {
        const std::size_t pixel = static_cast<std::size_t>(column) + across * static_cast<std::size_t>(row);
        image[pixel] = static_cast<float>(
            photon_count(static_cast<double>(image[pixel]) * detector.photons, detector.seed, pixel) /
            detector.photons);
      }
    });
  return image;
}

double attenuation_of(float received) noexcept {
  return std::min(15.99, -deterministic_log(std::max(1e-30, static_cast<double>(received))));
}

namespace {

/// Mean brightness around each pixel, from cells of 8 x 8 pixels that are smoothed and interpolated.
class Surround {
 public:
  /// `use(pixel)` returns true for the pixels that count; `brightness(pixel)` their value.
  template <class Use, class Brightness>
  Surround(const View& view, const Use& use, const Brightness& brightness)
      : across_((view.columns + k_cell - 1) / k_cell), down_((view.rows + k_cell - 1) / k_cell) {
    const auto count = static_cast<std::size_t>(across_) * static_cast<std::size_t>(down_);
    sums_.assign(count, 0);
    weights_.assign(count, 0);
    for (int row = 0; row < view.rows; ++row)
      for (int column = 0; column < view.columns; ++column) {
        const std::size_t pixel = static_cast<std::size_t>(column) +
                                  static_cast<std::size_t>(view.columns) * static_cast<std::size_t>(row);
        if (!use(pixel)) continue;
        const std::size_t cell = index(column / k_cell, row / k_cell);
        sums_[cell] += brightness(pixel), weights_[cell] += 1;
      }
    const int radius = std::max(1, static_cast<int>(std::lround(k_radius * across_)));
    for (int pass = 0; pass < 3; ++pass)  // three passes approximate a Gaussian
      for (std::vector<double>* values : {&sums_, &weights_}) {
        smooth(*values, across_, down_, 1, across_, radius);
        smooth(*values, down_, across_, across_, 1, radius);
      }
  }
  double at(int column, int row) const {
    const double x = std::clamp((column + 0.5) / k_cell - 0.5, 0.0, across_ - 1.0),
                 y = std::clamp((row + 0.5) / k_cell - 0.5, 0.0, down_ - 1.0);
    const int i = std::min(static_cast<int>(x), std::max(0, across_ - 2)),
              j = std::min(static_cast<int>(y), std::max(0, down_ - 2));
    double sum = 0, weight = 0;
    for (int dy = 0; dy < std::min(2, down_); ++dy)
      for (int dx = 0; dx < std::min(2, across_); ++dx) {
        const double share = (dx == 0 ? 1 - (x - i) : x - i) * (dy == 0 ? 1 - (y - j) : y - j);
        sum += share * sums_[index(i + dx, j + dy)], weight += share * weights_[index(i + dx, j + dy)];
      }
    return weight > 0 ? sum / weight : 0;
  }

 private:
  static constexpr int k_cell = 8;           // pixels
  static constexpr double k_radius = 0.035;  // of the width
  std::size_t index(int column, int row) const {
    return static_cast<std::size_t>(column) +
           static_cast<std::size_t>(across_) * static_cast<std::size_t>(row);
  }
  /// Replaces each value of `lines` lines of `length` values by the mean of its neighbours within `radius`.
  static void smooth(std::vector<double>& values, int length, int lines, int step, int line_step,
                     int radius) {
    std::vector<double> line(static_cast<std::size_t>(length));
    for (int l = 0; l < lines; ++l) {
      const auto value = [&](int i) -> double& {
        return values[static_cast<std::size_t>(l) * static_cast<std::size_t>(line_step) +
                      static_cast<std::size_t>(i) * static_cast<std::size_t>(step)];
      };
      for (int i = 0; i < length; ++i) {
        double sum = 0;
        for (int k = std::max(0, i - radius); k <= std::min(length - 1, i + radius); ++k) sum += value(k);
        line[static_cast<std::size_t>(i)] = sum / (2 * radius + 1);
      }
      for (int i = 0; i < length; ++i) value(i) = line[static_cast<std::size_t>(i)];
    }
  }

  int across_, down_;
  std::vector<double> sums_, weights_;
};

}  // namespace

std::vector<std::uint8_t> show(std::span<const float> received, const View& view, const Display& display,
                               std::span<const std::uint8_t> hidden) {
  const auto is_open = [&](std::size_t pixel) {
    const int column = static_cast<int>(pixel % static_cast<std::size_t>(view.columns)),
              row = static_cast<int>(pixel / static_cast<std::size_t>(view.columns));
    return column >= view.open.column_low && column < view.open.column_high && row >= view.open.row_low &&
           row < view.open.row_high && (hidden.empty() || !hidden[pixel]);
  };
  // Bright is more radiation.
  std::vector<double> brightness(received.size());
  for (std::size_t pixel = 0; pixel < received.size(); ++pixel)
    if (is_open(pixel))
      brightness[pixel] =
          display.is_logarithmic ? -attenuation_of(received[pixel]) : static_cast<double>(received[pixel]);
  // Pixels with matter in the beam; the rest is bright anyway.
  std::vector<double> attenuated, unattenuated;
  for (std::size_t pixel = 0; pixel < received.size(); ++pixel)
    if (is_open(pixel))
      (received[pixel] < k_empty_beam ? attenuated : unattenuated).push_back(brightness[pixel]);
  if (attenuated.size() < unattenuated.size() / 20)
    attenuated.insert(attenuated.end(), unattenuated.begin(), unattenuated.end());
  std::vector<std::uint8_t> grey(received.size(), k_closed_grey);
  if (attenuated.empty()) return grey;
  const auto percentile = [&](double share) {
    const auto at =
        attenuated.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(attenuated.size() - 1));
    std::nth_element(attenuated.begin(), at, attenuated.end());
    return *at;
  };
  if (display.is_logarithmic) {
    // Spread the greys over the body: parts much thinner than most of it would use up the range.
    const double thin = k_thin * percentile(0.25);
    std::vector<double> body;
    for (const double b : attenuated)
      if (b <= thin) body.push_back(b);
    if (body.size() > attenuated.size() / 4) attenuated = std::move(body);
  }
  if (display.is_logarithmic && display.equalization > 0) {
    // Thick and thin parts of the body differ more than bone and soft tissue. A part of the mean brightness
    // of the surround is subtracted, as in the processing of digital fluoroscopes, so that bone is visible in
    // both. Metal, which is darker than all bone, neither darkens its surround nor uses up the range.
    constexpr double k_metal = 1.35, k_dense_share = 0.05;
    const double brightest = percentile(1),
                 darkest = std::min(k_metal * percentile(k_dense_share), brightest);
    const Surround surround(
        view, is_open, [&](std::size_t pixel) { return std::clamp(brightness[pixel], darkest, brightest); });
    attenuated.clear();
    for (std::size_t pixel = 0; pixel < received.size(); ++pixel) {
      if (!is_open(pixel)) continue;
      const bool is_body = brightness[pixel] <= brightest;
      const int column = static_cast<int>(pixel % static_cast<std::size_t>(view.columns)),
                row = static_cast<int>(pixel / static_cast<std::size_t>(view.columns));
      brightness[pixel] =
          std::max(brightness[pixel], darkest) - display.equalization * surround.at(column, row);
      if (is_body) attenuated.push_back(brightness[pixel]);
    }
  }
  const double low = percentile(display.low_share), high = percentile(display.high_share);
  for (std::size_t pixel = 0; pixel < received.size(); ++pixel) {
    if (!is_open(pixel)) continue;
    double share = high > low ? std::clamp((brightness[pixel] - low) / (high - low), 0.0, 1.0) : 1.0;
    if (display.is_inverted) share = 1 - share;
    grey[pixel] = static_cast<std::uint8_t>(std::lround(255 * share));
  }
  return grey;
}

}  // namespace trephine::fluoroscopy
