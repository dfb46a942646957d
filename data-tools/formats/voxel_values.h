// fill_voxels(): converts values of any type to the 16-bit voxels of a volume, and measures the loss.
#pragma once

#include <functional>
#include <optional>
#include <span>

#include "volume/scan/volume.h"

namespace trephine::data_tools {

/// Reads the values of a file, in its units, from index `first` on.
using ValueReader = std::function<void(std::size_t first, std::span<double> values)>;

/// Returns a reader of numbers of type T, as slope * number + intercept. Borrows `data`.
template <class T>
ValueReader values_of(const void* data, double slope = 1, double intercept = 0) {
  return
      [numbers = static_cast<const T*>(data), slope, intercept](std::size_t first, std::span<double> values) {
        for (std::size_t i = 0; i < values.size(); ++i)
          values[i] = slope * static_cast<double>(numbers[first + i]) + intercept;
      };
}

/// Range of values, and their noise, estimated from differences of neighbours.
class ValueStatistics {
 public:
  ValueStatistics() = default;
  /// Creates statistics from a range and a noise that were measured before.
  ValueStatistics(double max_magnitude, double noise) : max_magnitude_(max_magnitude), known_noise_(noise) {}
  void add(std::span<const double> values);
  double max_magnitude() const noexcept { return max_magnitude_; }  ///< largest absolute value
  double noise() const;  ///< sigma; 0 if there are too few differences

 private:
  double max_magnitude_ = 0;
  std::optional<double> known_noise_;
  std::vector<double> differences_;
  std::size_t difference_count_ = 0, stride_ = 1;  ///< every stride_-th difference is kept
};

/// Step of 16-bit voxels, in units of the file.
struct ValueStep {
  double step = 1;
  bool is_finer_than_noise = false;
};
/// Returns a step with which all values fit into 16 bits: 1 if this suffices and the noise is at least 1.
ValueStep step_for(const ValueStatistics& statistics);

/// Returns the error for values whose noise is smaller than the step that 16 bits require.
Error too_coarse(const std::string& where, const ValueStatistics& statistics);

/// Fills a volume. Whole numbers that fit into 16 bits are kept. If values have fractions, all are rounded or
/// scaled, with a notice, provided that the step is at most their noise. `scale`, if given, is the step for
/// all values, with a notice. Error for other values, and for values that are not finite.
Status fill_voxels(volume::Volume& volume, const ValueReader& values, std::optional<double> scale,
                   const std::string& where, std::vector<std::string>& notices);

/// Metadata of our files for values in Hounsfield units, in DICOM's terms: key and value; in NIfTI, a note.
inline constexpr const char *k_units_key = "RescaleType", *k_units = "HU",
                            *k_hounsfield_note = "RescaleType HU";

/// Sets is_hounsfield if the values contain air, for formats without modality; voxels are unchanged. Returns
/// a notice, or "".
std::string guess_hounsfield(volume::Volume& volume);

}  // namespace trephine::data_tools
