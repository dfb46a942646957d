#include "data-tools/formats/voxel_values.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "data-tools/files/words.h"
#include "volume/base/text.h"

namespace trephine::data_tools {

namespace {

constexpr std::size_t k_part = 1 << 16;
constexpr std::size_t k_max_differences = 1 << 18;  // enough for a median
constexpr double k_max_voxel = 32700;               // leaves a margin for overshoot of interpolation

/// Calls visit(first, values) for all values in order until it returns false.
template <class Visit>
void for_each_part(std::size_t count, const ValueReader& values, const Visit& visit) {
  std::vector<double> part(std::min(count, k_part));
  for (std::size_t first = 0; first < count; first += k_part) {
    const std::span<double> chunk(part.data(), std::min(k_part, count - first));
    values(first, chunk);
    if (!visit(first, chunk)) return;
  }
}

}  // namespace

void ValueStatistics::add(std::span<const double> values) {
  for (std::size_t i = 0; i < values.size(); ++i) {
    max_magnitude_ = std::max(max_magnitude_, std::abs(values[i]));
    if (i + 1 == values.size() || values[i] == values[i + 1] || ++difference_count_ % stride_ != 0) continue;
    differences_.push_back(std::abs(values[i + 1] - values[i]));
    if (differences_.size() < k_max_differences) continue;
    for (std::size_t k = 0; 2 * k < differences_.size(); ++k) differences_[k] = differences_[2 * k];
    differences_.resize((differences_.size() + 1) / 2);
    stride_ *= 2;
  }
}

double ValueStatistics::noise() const {
  if (known_noise_) return *known_noise_;
  if (differences_.size() < 8) return 0;
  std::vector<double> sorted = differences_;
  const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2);
  std::nth_element(sorted.begin(), middle, sorted.end());
  return *middle / (0.6745 * std::sqrt(2.0));  // sigma of a normal distribution from its median deviation
}

ValueStep step_for(const ValueStatistics& statistics) {
  // Prefer whole units.
  const double noise = statistics.noise();
  if (statistics.max_magnitude() <= k_max_voxel && noise >= 1) return {1, true};
  // The step is rounded up to two digits, so that the notice can state it exactly.
  double step = statistics.max_magnitude() > 0 ? statistics.max_magnitude() / k_max_voxel : 1;
  const double digit = std::pow(10, std::floor(std::log10(step)) - 1);
  if (digit > 0) step = std::strtod(rounded_text(std::ceil(step / digit) * digit).c_str(), nullptr);
  return {step, step <= noise};
}

Error too_coarse(const std::string& where, const ValueStatistics& statistics) {
  return Error{
      .what = "rounding to 16 bits would exceed the noise of the values",
      .where = where,
      .found = "values up to " + rounded_text(statistics.max_magnitude()) + ", noise of " +
               rounded_text(statistics.noise()),
      .expected = "a step of at most " + rounded_text(statistics.noise()),
      .remedy = "accept a coarser step (option scale " + rounded_text(step_for(statistics).step) + ")"};
}

Status fill_voxels(volume::Volume& volume, const ValueReader& values, std::optional<double> scale,
                   const std::string& where, std::vector<std::string>& notices) {
  const std::size_t count = volume.voxels.size();
  std::int16_t* voxels = volume.voxels.data();
  std::size_t invalid_index = count;
  bool is_whole = !scale.has_value(), has_fractions = false;
  for_each_part(count, values, [&](std::size_t first, std::span<const double> part) {
    for (std::size_t i = 0; i < part.size() && invalid_index == count; ++i) {
      const double v = part[i];
      if (!std::isfinite(v)) invalid_index = first + i;
      has_fractions = has_fractions || v != std::floor(v);
      is_whole = is_whole && v >= -32768 && v <= 32767 && !has_fractions;
      if (is_whole) voxels[first + i] = static_cast<std::int16_t>(v);
    }
    return invalid_index == count;
  });
  if (invalid_index < count) {
    const auto nx = static_cast<std::size_t>(volume.size.x), ny = static_cast<std::size_t>(volume.size.y);
    return Error{.what = "a value is not finite (NaN or infinite)",
                 .where = where,
                 .found = "the first at voxel " + std::to_string(invalid_index % nx) + ", " +
                          std::to_string(invalid_index / nx % ny) + ", " +
                          std::to_string(invalid_index / nx / ny),
                 .expected = "numbers only",
                 .remedy = "replace such values before opening, for example by the value of air"};
  }
  if (is_whole) return std::nullopt;
  // Statistics are needed only for values that do not fit unchanged.
  ValueStatistics statistics;
  for_each_part(count, values, [&](std::size_t, std::span<const double> part) {
    statistics.add(part);
    return true;
  });
  const ValueStep value_step = scale ? ValueStep{*scale, true} : step_for(statistics);
  if (!(value_step.step > 0))
    return Error{.what = "the step is out of range",
                 .where = "scale",
                 .found = rounded_text(value_step.step),
                 .expected = "above 0",
                 .remedy = "state a positive number (option scale)"};
  if (has_fractions && !value_step.is_finer_than_noise) return too_coarse(where, statistics);
  if (statistics.max_magnitude() / value_step.step > 32767 || (!scale && !has_fractions))
    return Error{.what = "a value does not fit into 16 bits",
                 .where = where,
                 .found = rounded_text(statistics.max_magnitude()),
                 .expected = scale ? "at most " + rounded_text(32767 * value_step.step) : "-32768 to 32767",
                 .remedy = "read it with a coarser step (option scale " +
                           rounded_text(std::ceil(statistics.max_magnitude() / 32767 * 100) / 100) + ")"};
  for_each_part(count, values, [&](std::size_t first, std::span<const double> part) {
    for (std::size_t i = 0; i < part.size(); ++i)
      voxels[first + i] = static_cast<std::int16_t>(std::floor(part[i] / value_step.step + 0.5));
    return true;
  });
  if (scale)
    notices.push_back("one voxel unit is " + rounded_text(value_step.step) +
                      " of the file's units (option scale)");
  else if (value_step.step == 1)
    notices.push_back("values were rounded to whole numbers: rounding error at most 0.5, noise " +
                      rounded_text(statistics.noise()));
  else
    notices.push_back("values were scaled: one voxel unit is " + rounded_text(value_step.step) +
                      " of the file's units; rounding error at most " + rounded_text(0.5 * value_step.step) +
                      ", noise " + rounded_text(statistics.noise()));
  return std::nullopt;
}

std::string guess_hounsfield(volume::Volume& volume) {
  // Characteristic of CT: much air, and most of the values below water are air.
  std::size_t air = 0, below = 0, lowest_count = 0;
  std::int16_t least = 32767;
  for (const std::int16_t v : volume.voxels.span()) {
    air += v >= -1100 && v <= -900;
    below += v < -200;
    if (v < least) least = v, lowest_count = 0;
    lowest_count += v == least;
  }
  // One value far below air in many voxels is padding outside the field of view (-2000, -3024, ...).
  const std::size_t count = std::max<std::size_t>(volume.voxels.size(), 1);
  const bool has_padding = least < -1100 && 200 * lowest_count >= count;
  const std::size_t padding = has_padding ? lowest_count : 0;
  const double share = static_cast<double>(air) / static_cast<double>(count);
  volume.is_hounsfield = share >= 0.01 && 2 * air >= below - padding;
  if (!volume.is_hounsfield) return "";
  const auto percent = [count](std::size_t n) {
    return std::to_string(
        static_cast<int>(100.0 * static_cast<double>(n) / static_cast<double>(count) + 0.5));
  };
  return "assumed to be Hounsfield units: " + percent(air) + " % of the voxels are air (-1000)" +
         (has_padding ? ", " + percent(padding) + " % padding (" + std::to_string(least) + ")" : "");
}

}  // namespace trephine::data_tools
