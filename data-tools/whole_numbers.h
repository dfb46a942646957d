// Values of any kind into int16, or the first that does not fit.
#pragma once

#include <cmath>
#include <optional>

#include "volume/volume.h"

namespace trephine::data_tools {

/// Fills the volume with slope * value + intercept. Returns the first value that is not a whole number of 16
/// bits.
template <class T>
std::optional<double> fill_with_whole_numbers(const void* data, volume::Volume& volume, double slope = 1,
                                              double intercept = 0) {
  const T* from = static_cast<const T*>(data);
  for (std::size_t i = 0; i < volume.voxels.size(); ++i) {
    const double value = slope * static_cast<double>(from[i]) + intercept;
    if (!(value >= -32768 && value <= 32767) || value != std::floor(value)) return value;
    volume.voxels[i] = static_cast<std::int16_t>(value);
  }
  return std::nullopt;
}

volume::Error not_whole(const std::string& where, double value);

/// How a NIfTI file of ours says that its values are Hounsfield units.
inline constexpr const char* k_hounsfield_note = "RescaleType HU";

/// For formats that name no modality: sets is_hounsfield when there is the evidence of air, and alters
/// nothing. Returns a notice, or "".
std::string guess_hounsfield(volume::Volume& volume);

}  // namespace trephine::data_tools
