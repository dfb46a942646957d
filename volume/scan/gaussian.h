// Separable Gaussian blur, as a model of a scanner's point spread function.
#pragma once

#include <glm/vec3.hpp>
#include <span>

#include "volume/scan/volume.h"

namespace trephine::volume {

/// Blurs `values` (size.x * size.y * size.z, x fastest) in place; sigma in voxels along each axis, 0 skips
/// that axis. The kernel is truncated at 4 sigma and normalized; border values are repeated outside. The
/// result is identical for any number of threads.
void gaussian_blur(std::span<float> values, const glm::ivec3& size, const glm::dvec3& sigma_voxels,
                   int threads = 0);

/// Returns a copy with blurred intensities, rounded to the nearest whole number, and unchanged labels.
Result<Volume> gaussian_blurred(const Volume& volume, const glm::dvec3& sigma_voxels, int threads = 0);

}  // namespace trephine::volume
