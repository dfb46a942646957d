// The operated state as a plain volume that other programs read.
#pragma once

#include "volume/version.h"

namespace trephine::volume {

/// The base with every voxel moved toward air (-1000 HU; the lowest value without HU) in proportion to what
/// was removed of it. `version` is frozen, or no edit runs meanwhile. Labels of voxels that are wholly gone
/// become 0.
Result<Volume> operated_volume(const Version& version);
/// Value of wholly removed voxels: -1000 HU; of a volume without HU its lowest value, for which all of it
/// is read.
double air_of(const Volume& base);
/// The voxels low .. high, x fastest, of the same.
void read_operated(const Version& version, const VoxelBox& box, double air, std::int16_t* intensities);

}  // namespace trephine::volume
