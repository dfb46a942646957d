// Operated volume: the current state as a plain volume, for export to other programs.
#pragma once

#include "volume/cuts/version.h"

namespace trephine::volume {

/// Returns a copy of the base in which each voxel's intensity approaches air_of() by its removed share.
/// Labels of completely removed voxels become 0. Requires a frozen `version`, or that no edit runs meanwhile.
Result<Volume> operated_volume(const Version& version);
/// Value of completely removed voxels: -1000 HU; in a volume without HU its lowest value (reads all voxels).
double air_of(const Volume& base);
/// Writes the operated intensities of the voxels of `box` (inside the grid), x fastest. `air`: from air_of().
void read_operated(const Version& version, const VoxelBox& box, double air, std::int16_t* intensities);

}  // namespace trephine::volume
