#include "data-tools/voxel_values.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "data-tools/words.h"

namespace trephine::data_tools {

using volume::Error;
using volume::Status;

namespace {

constexpr std::size_t k_part = 1 << 16;
constexpr std::size_t k_jumps = 1 << 18;  // enough for a median
constexpr double k_most_voxel = 32700;    // a little is left for what interpolation overshoots

/// Calls see(first, values) for all of them in order until it returns false.
template <class See>
void for_all(std::size_t count, const ValueReader& values, const See& see) {
  std::vector<double> part(std::min(count, k_part));
  for (std::size_t first = 0; first < count; first += k_part) {
    const std::span<double> now(part.data(), std::min(k_part, count - first));
    values(first, now);
    if (!see(first, now)) return;
  }
}

}  // namespace

void ValueStatistics::add(std::span<const double> values) {
  for (std::size_t i = 0; i < values.size(); ++i) {
    most_ = std::max(most_, std::abs(values[i]));
    if (i + 1 == values.size() || values[i] == values[i + 1] || ++seen_ % every_ != 0) continue;
    jumps_.push_back(std::abs(values[i + 1] - values[i]));
    if (jumps_.size() < k_jumps) continue;
    for (std::size_t k = 0; 2 * k < jumps_.size(); ++k) jumps_[k] = jumps_[2 * k];
    jumps_.resize((jumps_.size() + 1) / 2);
    every_ *= 2;
  }
}

double ValueStatistics::noise() const {
  if (known_noise_) return *known_noise_;
  if (jumps_.size() < 8) return 0;
  std::vector<double> sorted = jumps_;
  const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2);
  std::nth_element(sorted.begin(), middle, sorted.end());
  return *middle / (0.6745 * std::sqrt(2.0));  // of a normal distribution
}

ValueStep step_for(const ValueStatistics& statistics) {
  // Whole units are the easiest to understand.
  const double noise = statistics.noise();
  if (statistics.most() <= k_most_voxel && noise >= 1) return {1, true};
  // Two digits, rounded up: the notice has the value that was used.
  double step = statistics.most() > 0 ? statistics.most() / k_most_voxel : 1;
  const double digit = std::pow(10, std::floor(std::log10(step)) - 1);
  if (digit > 0) step = std::strtod(short_number(std::ceil(step / digit) * digit).c_str(), nullptr);
  return {step, step <= noise};
}

Error too_coarse(const std::string& where, const ValueStatistics& statistics) {
  return {"16 bits would lose more of the values than their noise", where,
          "values to " + short_number(statistics.most()) + ", noise of " + short_number(statistics.noise()),
          "a step of at most " + short_number(statistics.noise()),
          "accept a coarser step: --scale " + short_number(step_for(statistics).step)};
}

Status fill_voxels(volume::Volume& volume, const ValueReader& values, std::optional<double> scale,
                   const std::string& where, std::vector<std::string>& notices) {
  const std::size_t count = volume.voxels.size();
  std::int16_t* to = volume.voxels.data();
  std::size_t no_number = count;
  bool is_whole = !scale.has_value(), has_fractions = false;
  for_all(count, values, [&](std::size_t first, std::span<const double> part) {
    for (std::size_t i = 0; i < part.size() && no_number == count; ++i) {
      const double v = part[i];
      if (!std::isfinite(v)) no_number = first + i;
      has_fractions = has_fractions || v != std::floor(v);
      is_whole = is_whole && v >= -32768 && v <= 32767 && !has_fractions;
      if (is_whole) to[first + i] = static_cast<std::int16_t>(v);
    }
    return no_number == count;
  });
  if (no_number < count) {
    const auto nx = static_cast<std::size_t>(volume.size.x), ny = static_cast<std::size_t>(volume.size.y);
    return Error{"a value is no number (NaN or infinite)", where,
                 "the first at voxel " + std::to_string(no_number % nx) + ", " +
                     std::to_string(no_number / nx % ny) + ", " + std::to_string(no_number / nx / ny),
                 "numbers only", "replace such values before opening, for example by that of air"};
  }
  if (is_whole) return std::nullopt;
  // Only what does not fit as it is, is measured.
  ValueStatistics statistics;
  for_all(count, values, [&](std::size_t, std::span<const double> part) {
    statistics.add(part);
    return true;
  });
  const ValueStep found = scale ? ValueStep{*scale, true} : step_for(statistics);
  if (!(found.step > 0))
    return Error{"the step is out of range", "scale", short_number(found.step), "above 0", ""};
  if (has_fractions && !found.is_finer_than_noise) return too_coarse(where, statistics);
  if (statistics.most() / found.step > 32767 || (!scale && !has_fractions))
    return Error{"a value does not fit into 16 bits", where, short_number(statistics.most()),
                 scale ? "at most " + short_number(32767 * found.step) : "-32768 to 32767",
                 "read it with a coarser step, such as --scale " +
                     short_number(std::ceil(statistics.most() / 32767 * 100) / 100)};
  for_all(count, values, [&](std::size_t first, std::span<const double> part) {
    for (std::size_t i = 0; i < part.size(); ++i)
      to[first + i] = static_cast<std::int16_t>(std::floor(part[i] / found.step + 0.5));
    return true;
  });
  if (scale)
    notices.push_back("a voxel's step is " + short_number(found.step) + " of the file's units (--scale)");
  else if (found.step == 1)
    notices.push_back("values were rounded to whole numbers: at most 0.5 off, noise is " +
                      short_number(statistics.noise()));
  else
    notices.push_back("values were scaled: the file's units are " + short_number(found.step) +
                      " x voxel, at most " + short_number(0.5 * found.step) + " off, noise is " +
                      short_number(statistics.noise()));
  return std::nullopt;
}

std::string guess_hounsfield(volume::Volume& volume) {
  // Air all around, or most of what lies below water: no other modality has that.
  std::size_t air = 0, below = 0, least_count = 0;
  std::int16_t least = 32767;
  for (const std::int16_t v : volume.voxels.span()) {
    air += v >= -1100 && v <= -900;
    below += v < -200;
    if (v < least) least = v, least_count = 0;
    least_count += v == least;
  }
  // One value far below air in many voxels is padding outside the field of view (-2000, -3024, ...).
  const std::size_t count = std::max<std::size_t>(volume.voxels.size(), 1);
  const bool has_padding = least < -1100 && 200 * least_count >= count;
  const std::size_t padding = has_padding ? least_count : 0;
  const double share = static_cast<double>(air) / static_cast<double>(count);
  volume.is_hounsfield = share >= 0.01 && 2 * air >= below - padding;
  if (!volume.is_hounsfield) return "";
  const auto percent = [count](std::size_t n) {
    return std::to_string(
        static_cast<int>(100.0 * static_cast<double>(n) / static_cast<double>(count) + 0.5));
  };
  return "taken as Hounsfield units: " + percent(air) + " % of the voxels are air (-1000)" +
         (has_padding ? ", " + percent(padding) + " % padding (" + std::to_string(least) + ")" : "");
}

}  // namespace trephine::data_tools
