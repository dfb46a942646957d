// Attenuation of a beam by matter: linear attenuation coefficients by photon energy, and their relation to
// Hounsfield units.
#pragma once

#include <string_view>

#include "volume/imaging/line_integrals.h"
#include "volume/scan/matter.h"

namespace trephine::fluoroscopy {

using volume::Matter;

inline constexpr double k_lowest_energy = 20, k_highest_energy = 150;  ///< keV
/// Effective energy that is assumed for the Hounsfield units of scanners, keV (120 kV).
inline constexpr double k_scanner_energy = 70;
/// HU up to which a voxel counts as air: a scanner's noise in air does not attenuate.
inline constexpr std::int16_t k_air_below = -900;

/// Returns the attenuation coefficient, 1/mm, of soft tissue (water), cortical bone (1.92 g/cm3), titanium
/// (4.54) or iron (7.874): mass attenuation of Hubbell and Seltzer (NISTIR 5632, 1995), with power laws
/// between their energies. Scenery attenuates nothing.
double attenuation(Matter matter, double energy_kev) noexcept;

/// Returns the attenuation of voxels, 1/mm, at an energy: linear from air (-1000 HU, zero) to water (0 HU),
/// from there to cortical bone, with HU by the scanner's energy, and beyond on the same line. HU up to
/// k_air_below count as zero.
volume::VoxelWeights weights_of_hounsfield(double energy_kev) noexcept;

}  // namespace trephine::fluoroscopy
