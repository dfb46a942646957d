// LineIntegrals: weighted sums of voxels along rays from one point, the projections of X-ray images. The sums
// are exact, voxel by voxel (Siddon 1985), or interpolated between voxel centres (Joseph 1982).
#pragma once

#include <algorithm>
#include <limits>
#include <span>
#include <vector>

#include "volume/cuts/rays.h"
#include "volume/imaging/line_kernels.h"

namespace trephine::volume {

/// Weight per mm of a voxel by its intensity. It is 0 up to the larger of `zero` and `highest_weightless`.
/// Above this, it is linear in the intensity above `zero`, with a change of slope at `knee`.
struct VoxelWeights {
  std::int16_t highest_weightless = -1000, zero = -1000, knee = 0;  ///< intensities; zero <= knee
  float below = 1e-3f, above = 1e-3f;  ///< weight per step of intensity, below and above knee

  double of(std::int32_t intensity) const noexcept {
    if (intensity <= highest_weightless) return 0;
    const int over = std::max(0, intensity - zero), low = std::min(over, knee - zero);
    return static_cast<double>(below) * low + static_cast<double>(above) * (over - low);
  }
};

/// Rays from one point to the centres of pixels (i, j) at corner + i right + j down. Volume frame.
struct RayFan {
  glm::dvec3 source{0.0}, corner{0.0}, right{0.0}, down{0.0};
  int columns = 0, rows = 0;

  glm::dvec3 pixel(double i, double j) const noexcept { return corner + i * right + j * down; }
  /// Axis perpendicular to the slabs in which the ray to a pixel is integrated: the axis of the largest
  /// component of the middle ray of the pixel's packet of eight.
  int slab_axis(int i, int j) const noexcept {
    const glm::dvec3 along = glm::abs(pixel(std::min((i & ~7) + 3.5, columns - 1.0), j) - source);
    return along.x > along.y ? (along.x > along.z ? 0 : 2) : (along.y > along.z ? 1 : 2);
  }
};
/// Box of the pixels low .. high - 1.
struct PixelBox {
  int column_low = 0, row_low = 0, column_high = 0, row_high = 0;
  bool is_empty() const noexcept { return column_low >= column_high || row_low >= row_high; }
};

/// Method of integration.
enum class RaySum : std::uint8_t { exact, joseph };

/// Integrates weight(voxel) over the ray parameter from `t_begin` to `t_end` (within 0 .. 1), inside a box of
/// voxels; exactly, in double precision. Requires coordinates below k_traversal_limit. The sums of adjacent
/// boxes add up to that of their union.
template <class Weight>
double sum_along(const Ray& ray, double t_begin, double t_end, const VoxelBox& box,
                 const Weight& weight) noexcept;

class LineIntegrals {
 public:
  /// Borrows the volume. Makes one pass over it, to find the empty blocks: those of 8 x 8 x 8 voxels
  /// without an intensity above VoxelWeights::highest_weightless. threads 0 = all cores.
  LineIntegrals(const Volume& volume, const VoxelWeights& weights, int threads = 0,
                const LineKernels& kernels = best_line_kernels());

  /// Computes, for the pixels of the box, the integral of the weights over each ray's parameter from the
  /// source (0) to the pixel (1); multiply by the ray's length in mm. `sums`: one value per pixel of the
  /// whole fan, row by row. A ray in a plane between voxels counts those on the higher side, as in
  /// volume/scan/traversal.h. The result is identical for any number of threads and with or without skipping
  /// of empty blocks. Errors of exact sums are below 1e-6 of the sum, or of the integral over a path of one
  /// voxel at the largest weight, if that is larger. Writes 0 for rays with coordinates that are not finite
  /// or beyond k_traversal_limit.
  void integrate(const RayFan& fan, const PixelBox& box, RaySum method, int threads,
                 std::span<double> sums) const;
  /// Returns the exact integral of one ray between two parameters, in double precision.
  double integrate(const Ray& ray, double t_begin = 0, double t_end = 1) const noexcept;

  const VoxelWeights& weights() const noexcept { return weights_; }
  /// Returns true if any voxel of the block (voxel >> 3) is above VoxelWeights::highest_weightless.
  bool is_filled(const glm::ivec3& block) const noexcept {
    return views_[2].bits[views_[2].word(block.z, block.y, block.x >> 6)] >> (block.x & 63) & 1u;
  }
  const glm::ivec3& blocks() const noexcept { return blocks_; }

 private:
  /// The volume as slabs perpendicular to one axis, with one bit per block, set if the block is not empty.
  struct View {
    int d = 0, a = 0, b = 0;  ///< axes, as in SlabVolume
    SlabVolume slabs{};
    int size_d = 0, words = 0, rows = 0;  ///< voxels along d; words per row and rows per layer of bits
    std::vector<std::uint64_t> bits;      ///< by layers of blocks, in rows along a

    std::size_t word(int layer, int row, int w) const noexcept {
      return (static_cast<std::size_t>(layer) * static_cast<std::size_t>(rows) +
              static_cast<std::size_t>(row)) *
                 static_cast<std::size_t>(words) +
             static_cast<std::size_t>(w);
    }
    bool is_empty(int layer, const glm::dvec2& low, const glm::dvec2& high) const noexcept;
  };
  struct Tile;

  void find_filled(int threads);
  void integrate_tile(const RayFan& fan, const PixelBox& tile, RaySum method, double* sums) const;

  const Volume* volume_;
  VoxelWeights weights_;
  const LineKernels* kernels_;
  glm::ivec3 blocks_;
  std::array<View, 3> views_;
};

template <class Weight>
double sum_along(const Ray& ray, double t_begin, double t_end, const VoxelBox& box,
                 const Weight& weight) noexcept {
  constexpr double k_never = std::numeric_limits<double>::infinity();
  const glm::dvec3 along = ray.end - ray.start;
  const auto voxel_along = [](double p) noexcept { return voxel_of({p, 0, 0}).x; };
  // Clips the ray at the faces of the box.
  double t_in = t_begin, t_out = t_end;
  int entry_axis = -1;
  for (int a = 0; a < 3; ++a) {
    if (along[a] == 0) {
      const int v = voxel_along(ray.start[a]);
      if (v < box.low[a] || v > box.high[a]) return 0;
      continue;
    }
    const double low = (box.low[a] - 0.5 - ray.start[a]) / along[a],
                 high = (box.high[a] + 0.5 - ray.start[a]) / along[a];
    if (std::min(low, high) > t_in) t_in = std::min(low, high), entry_axis = a;
    t_out = std::min(t_out, std::max(low, high));
  }
  if (!(t_in < t_out)) return 0;
  glm::ivec3 voxel, step{0};
  glm::dvec3 next{k_never};  // parameter at the next plane along each axis
  const auto plane_at = [&](int a) { return (voxel[a] + 0.5 * step[a] - ray.start[a]) / along[a]; };
  for (int a = 0; a < 3; ++a) {
    step[a] = along[a] > 0 ? 1 : along[a] < 0 ? -1 : 0;
    if (step[a] == 0) {
      voxel[a] = voxel_along(ray.start[a]);
      continue;
    }
    voxel[a] = a == entry_axis
                   ? (step[a] > 0 ? box.low[a] : box.high[a])
                   : std::clamp(voxel_along(ray.start[a] + t_in * along[a]), box.low[a], box.high[a]);
    next[a] = plane_at(a);
    // Advances past planes that rounding placed behind the entry.
    while (next[a] <= t_in && voxel[a] + step[a] >= box.low[a] && voxel[a] + step[a] <= box.high[a])
      voxel[a] += step[a], next[a] = plane_at(a);
  }
  double sum = 0, t = t_in;
  for (;;) {
    const int a = next.x < next.y ? (next.x < next.z ? 0 : 2) : (next.y < next.z ? 1 : 2);
    const double end = std::min(next[a], t_out);
    if (end > t) sum += (end - t) * weight(voxel), t = end;
    if (next[a] >= t_out) return sum;
    voxel[a] += step[a];
    if (voxel[a] < box.low[a] || voxel[a] > box.high[a]) return sum;
    next[a] = plane_at(a);
  }
}

}  // namespace trephine::volume
