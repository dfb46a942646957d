// Shape and cuts of a volume as plain samples for the judges: read from voxels and distances, never from
// occupancy bits.
#pragma once

#include <memory>
#include <optional>

#include "apps/verify/fall_through.h"
#include "apps/verify/smooth_judge.h"
#include "volume/cuts/version.h"
#include "volume/fields/soft_field.h"
#include "volume/scan/shape.h"

namespace trephine::verify {

/// Returns a function that returns true if a voxel inside the grid belongs to the shape and is not removed.
/// `version`: null if nothing was removed.
SolidVoxels solid_voxels(std::shared_ptr<const volume::Volume> base, const volume::Shape& shape,
                         std::shared_ptr<const volume::Version> version = nullptr);

/// Returns the intensity at p (volume frame), linear between voxels; near the border, the weighted mean of
/// those voxels that are inside the grid. Nullopt if p is a voxel or more beyond the outermost voxel centres.
std::optional<double> intensity_at(const volume::Volume& base, const glm::dvec3& p);

/// Returns the smooth solid of the shape without removed matter. `soft`: soft field of the shape; may be
/// null.
SmoothSolid smooth_solid(std::shared_ptr<const volume::Volume> base, const volume::Shape& shape,
                         std::shared_ptr<const volume::Version> version = nullptr,
                         std::shared_ptr<const volume::SoftField> soft = nullptr);

}  // namespace trephine::verify
