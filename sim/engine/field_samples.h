// Samples of an offset field for the hash of a result.
#pragma once

#include "volume/base/mix_hash.h"
#include "volume/fields/offset_field.h"

namespace trephine::sim {

/// Adds `count` samples to a hash, at fixed pseudo-random points in a box of the field's lattice. The hash
/// thus depends on radius, step, shape and cuts. Cost: about 20 ns per sample.
void add_samples(MixHash& hash, const volume::OffsetField& field, const volume::VoxelBox& box, int count);
/// Returns the box of the field's lattice in which a cut of these voxels (of `frame`) changes distances.
volume::VoxelBox lattice_box(const volume::OffsetField& field, const volume::Frame& frame,
                             const volume::VoxelBox& cut);

}  // namespace trephine::sim
