#include "volume/scan/gaussian.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "volume/base/deterministic_math.h"
#include "volume/base/parallel.h"

namespace trephine::volume {

namespace {

std::vector<float> kernel(double sigma) {
  const int radius = static_cast<int>(std::ceil(4 * sigma));
  std::vector<double> weights;
  double sum = 0;
  for (int i = -radius; i <= radius; ++i) {
    weights.push_back(deterministic_exp(-0.5 * i * i / (sigma * sigma)));
    sum += weights.back();
  }
  std::vector<float> result;
  for (const double w : weights) result.push_back(static_cast<float>(w / sum));
  return result;
}

/// Replaces each of `count` rows of `length` values, `stride` apart, by a weighted sum of the rows around it.
void blur_rows(float* first, std::size_t stride, int count, std::size_t length,
               const std::vector<float>& weights) {
  const int radius = static_cast<int>(weights.size() / 2);
  std::vector<float> copy(static_cast<std::size_t>(count) * length);
  for (int r = 0; r < count; ++r)
    std::copy_n(first + static_cast<std::size_t>(r) * stride, length,
                copy.data() + static_cast<std::size_t>(r) * length);
  for (int r = 0; r < count; ++r) {
    float* out = first + static_cast<std::size_t>(r) * stride;
    std::fill_n(out, length, 0.0f);
    for (int k = -radius; k <= radius; ++k) {
      const float w = weights[static_cast<std::size_t>(k + radius)];
      const float* in = copy.data() + static_cast<std::size_t>(std::clamp(r + k, 0, count - 1)) * length;
      for (std::size_t i = 0; i < length; ++i) out[i] += w * in[i];
    }
  }
}

void blur_line(float* row, int count, const std::vector<float>& weights, std::vector<float>& padded) {
  const int radius = static_cast<int>(weights.size() / 2);
  padded.resize(static_cast<std::size_t>(count + 2 * radius));
  for (int i = 0; i < count + 2 * radius; ++i)
    padded[static_cast<std::size_t>(i)] = row[std::clamp(i - radius, 0, count - 1)];
  std::fill_n(row, count, 0.0f);
  for (std::size_t k = 0; k < weights.size(); ++k)
    for (int i = 0; i < count; ++i) row[i] += weights[k] * padded[k + static_cast<std::size_t>(i)];
}

}  // namespace

void gaussian_blur(std::span<float> values, const glm::ivec3& size, const glm::dvec3& sigma, int threads) {
  const auto nx = static_cast<std::size_t>(size.x), slice = nx * static_cast<std::size_t>(size.y);
  if (sigma.x > 0 || sigma.y > 0) {
    const std::vector<float> along_x = sigma.x > 0 ? kernel(sigma.x) : std::vector<float>();
    const std::vector<float> along_y = sigma.y > 0 ? kernel(sigma.y) : std::vector<float>();
    parallel_for(size.z, threads, [&](int z) {
      float* first = values.data() + static_cast<std::size_t>(z) * slice;
      std::vector<float> padded;
      if (sigma.x > 0)
        for (int y = 0; y < size.y; ++y)
          blur_line(first + static_cast<std::size_t>(y) * nx, size.x, along_x, padded);
      if (sigma.y > 0) blur_rows(first, nx, size.y, nx, along_y);
    });
  }
  if (sigma.z > 0) {
    const std::vector<float> along_z = kernel(sigma.z);
    parallel_for(size.y, threads, [&](int y) {
      blur_rows(values.data() + static_cast<std::size_t>(y) * nx, slice, size.z, nx, along_z);
    });
  }
}

Result<Volume> gaussian_blurred(const Volume& volume, const glm::dvec3& sigma_voxels, int threads) {
  Result<Volume> output = make_volume(volume.size, volume.frame, !volume.labels.is_empty());
  if (!output) return output;
  Volume& result = output.value();
  result.copy_interpretation(volume);
  std::copy_n(volume.labels.data(), volume.labels.size(), result.labels.data());
  const auto blur = [&](const Buffer<std::int16_t>& from, Buffer<std::int16_t>& to) {
    std::vector<float> values(from.span().begin(), from.span().end());
    gaussian_blur(values, volume.size, sigma_voxels, threads);
    for (std::size_t i = 0; i < values.size(); ++i)
      to[i] = static_cast<std::int16_t>(std::floor(values[i] + 0.5f));
  };
  blur(volume.voxels, result.voxels);
  if (!volume.shape_voxels.is_empty()) {
    result.shape_voxels = Buffer<std::int16_t>(volume.voxels.size());
    blur(volume.shape_voxels, result.shape_voxels);
  }
  return output;
}

}  // namespace trephine::volume
