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
/// Largest HU value of a voxel that counts as air, so that the noise of a scanner in air does not attenuate.
inline constexpr std::int16_t k_air_below = -900;

/// Returns the linear attenuation coefficient, 1/mm, of soft tissue (as water), cortical bone (1.92 g/cm3),
/// titanium (4.54 g/cm3) or steel (as iron, 7.874 g/cm3). The mass attenuation coefficients are those of
/// Hubbell and Seltzer (NISTIR 5632, 1995), interpolated by power laws between the tabulated energies.
/// Energies outside k_lowest_energy to k_highest_energy are clamped. Scenery attenuates nothing.
double attenuation(Matter matter, double energy_kev) noexcept;

/// Returns the attenuation of voxels, 1/mm, at an energy. It is piecewise linear: 0 at -1000 HU (air), that
/// of water at 0 HU, and that of cortical bone at the HU value that bone has at k_scanner_energy. Above 0 HU
/// the same line continues beyond cortical bone. Voxels of at most k_air_below do not attenuate.
volume::VoxelWeights weights_of_hounsfield(double energy_kev) noexcept;

}  // namespace trephine::fluoroscopy
