// Attenuation of a beam by matter: linear attenuation coefficients by photon energy, and what scanner
// numbers stand for.
#pragma once

#include <string_view>

#include "volume/line_integrals.h"

namespace trephine::fluoroscopy {

enum class Matter : std::uint8_t { water, bone, titanium, steel };
inline constexpr std::string_view k_matter[] = {"water", "bone", "titanium", "steel"};

inline constexpr double k_lowest_energy = 20, k_highest_energy = 150;  ///< keV
/// Effective energy at which scanners' Hounsfield units are taken to be measured, keV (120 kV).
inline constexpr double k_scanner_energy = 70;
/// HU up to which a voxel counts as air: a scanner's noise in air does not attenuate.
inline constexpr std::int16_t k_air_below = -900;

/// 1/mm, of water, cortical bone (1.92 g/cm3), titanium (4.54) and iron (7.874): mass attenuation of Hubbell
/// and Seltzer (NISTIR 5632, 1995), between their energies by powers.
double attenuation(Matter matter, double energy_kev) noexcept;

/// Attenuation of a voxel a mm at an energy: from air (-1000 HU, nothing) to water (0 HU) and from there to
/// cortical bone, whose HU follow from the scanner's energy, and on along that line. HU up to k_air_below
/// count nothing.
volume::VoxelWeights weights_of_hounsfield(double energy_kev) noexcept;

}  // namespace trephine::fluoroscopy
