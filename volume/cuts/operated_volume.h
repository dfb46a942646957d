// Operated volume: the current state as a plain volume, for export to other programs.
#pragma once

#include "volume/cuts/version.h"

namespace trephine::volume {

/// Returns a copy of the base in which the removed share of each voxel has the intensity air_of(): intensity
/// + share * (air_of() - intensity). Labels of completely removed voxels become 0. Requires a frozen
/// `version`, or that no edit runs during the call.
Result<Volume> operated_volume(const Version& version);
/// Intensity of completely removed voxels: -1000 HU; in a volume without HU, the lowest value of the volume
/// (reads all voxels).
double air_of(const Volume& base);
/// Writes the intensities of operated_volume() for the voxels of `box` (inside the grid), x fastest. `air`:
/// from air_of(). The requirement on `version` is that of operated_volume().
void read_operated(const Version& version, const VoxelBox& box, double air, std::int16_t* intensities);

}  // namespace trephine::volume
