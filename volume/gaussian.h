// Separable Gaussian blur, the model of a scanner's point spread.
#pragma once

#include <glm/vec3.hpp>
#include <span>

#include "volume/volume.h"

namespace trephine::volume {

/// Blurs `values` (size.x * size.y * size.z, x fastest) in place; sigma in voxels along each axis, 0 leaves
/// that axis alone. Kernel cut at 4 sigma and normalized; edge values continue outside. Same bits for any
/// threads.
void gaussian_blur(std::span<float> values, const glm::ivec3& size, const glm::dvec3& sigma_voxels,
                   int threads = 0);

/// Blurs a volume's intensities, rounded to the nearest whole number; labels are kept.
Result<Volume> gaussian_blurred(const Volume& volume, const glm::dvec3& sigma_voxels, int threads = 0);

}  // namespace trephine::volume
