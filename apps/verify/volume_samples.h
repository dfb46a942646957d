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

/// Returns a predicate: the voxel is solid for the shape and not removed. For use inside the grid. Null
/// version: untouched.
SolidVoxels solid_voxels(std::shared_ptr<const volume::Volume> base, const volume::Shape& shape,
                         std::shared_ptr<const volume::Version> version = nullptr);

/// Returns the intensity at p (volume frame), linear between voxels; near the border, of the voxels inside
/// the grid. Empty outside.
std::optional<double> intensity_at(const volume::Volume& base, const glm::dvec3& p);

/// Returns the smooth solid of the shape and of the cuts; `soft`: soft field of the shape, may be null.
SmoothSolid smooth_solid(std::shared_ptr<const volume::Volume> base, const volume::Shape& shape,
                         std::shared_ptr<const volume::Version> version = nullptr,
                         std::shared_ptr<const volume::SoftField> soft = nullptr);

}  // namespace trephine::verify
