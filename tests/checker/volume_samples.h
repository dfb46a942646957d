// A volume's shape and cuts as plain samples, for the judges: read from voxels and distances, never from
// bits.
#pragma once

#include <memory>
#include <optional>

#include "tests/checker/fall_through.h"
#include "tests/checker/smooth_judge.h"
#include "volume/shape.h"
#include "volume/soft_field.h"
#include "volume/version.h"

namespace trephine::checker {

/// Is the voxel solid for the shape, and not removed? Asked inside the grid only. Null version: untouched.
SolidVoxels solid_voxels(std::shared_ptr<const volume::Volume> base, const volume::Shape& shape,
                         std::shared_ptr<const volume::Version> version = nullptr);

/// The intensity at p (volume frame), linear between voxels; of the voxels that there are where p is near the
/// border. Nothing outside.
std::optional<double> intensity_at(const volume::Volume& base, const glm::dvec3& p);

/// The smooth solid of the shape and of what was removed; `soft`: where the shape was made smooth.
SmoothSolid smooth_solid(std::shared_ptr<const volume::Volume> base, const volume::Shape& shape,
                         std::shared_ptr<const volume::Version> version = nullptr,
                         std::shared_ptr<const volume::SoftField> soft = nullptr);

}  // namespace trephine::checker
