// Values of any kind into the 16 bits of a volume, and what that loses.
#pragma once

#include <functional>
#include <optional>
#include <span>

#include "volume/volume.h"

namespace trephine::data_tools {

/// Values of a file in its units, so many from `first` on.
using ValueReader = std::function<void(std::size_t first, std::span<double> to)>;

/// Numbers of one type, as slope * value + intercept.
template <class T>
ValueReader values_of(const void* data, double slope = 1, double intercept = 0) {
  return [from = static_cast<const T*>(data), slope, intercept](std::size_t first, std::span<double> to) {
    for (std::size_t i = 0; i < to.size(); ++i)
      to[i] = slope * static_cast<double>(from[first + i]) + intercept;
  };
}

/// Range of values, and their noise: of differences of neighbours.
class ValueStatistics {
 public:
  ValueStatistics() = default;
  /// Adds what was collected elsewhere.
  ValueStatistics(double most, double noise) : most_(most), known_noise_(noise) {}
  void add(std::span<const double> values);
  double most() const noexcept { return most_; }  ///< of absolute values
  double noise() const;                           ///< sigma; 0 when there are too few differences

 private:
  double most_ = 0;
  std::optional<double> known_noise_;
  std::vector<double> jumps_;
  std::size_t seen_ = 0, every_ = 1;  ///< every so manieth difference is kept
};

/// The coarsest step that 16 bits need for such values, and whether it is finer than their noise.
struct ValueStep {
  double step = 1;
  bool is_finer_than_noise = false;
};
ValueStep step_for(const ValueStatistics& statistics);

/// "16 bits would lose more ...": with the way out.
volume::Error too_coarse(const std::string& where, const ValueStatistics& statistics);

/// Whole numbers that fit go in as they are. Others are rounded or scaled where that loses less than their
/// noise, or as `scale` has it, with a notice; else refused.
volume::Status fill_voxels(volume::Volume& volume, const ValueReader& values, std::optional<double> scale,
                           const std::string& where, std::vector<std::string>& notices);

/// Marks of our files for values in Hounsfield units, in DICOM's words; NIfTI has one note only.
inline constexpr const char *k_units_key = "RescaleType", *k_units = "HU",
                            *k_hounsfield_note = "RescaleType HU";

/// For formats that name no modality: sets is_hounsfield when there is the evidence of air, and alters
/// nothing. Returns a notice, or "".
std::string guess_hounsfield(volume::Volume& volume);

}  // namespace trephine::data_tools
