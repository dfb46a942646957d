// Sums of a volume's voxels along rays from one point: the projections behind X-ray images. Exact, voxel by
// voxel (Siddon 1985), or between voxels' centres (Joseph 1982).
#pragma once

#include <algorithm>
#include <limits>
#include <span>
#include <vector>

#include "volume/line_kernels.h"
#include "volume/rays.h"

namespace trephine::volume {

/// Weight of a voxel of some intensity a mm: along two straight lines, from 0 at `zero` up to a knee and
/// beyond it; nothing up to `none`.
struct VoxelWeights {
  std::int16_t none = -1000, zero = -1000, knee = 0;  ///< zero <= knee
  float below = 1e-3f, above = 1e-3f;                 ///< for each step of intensity

  double of(std::int32_t intensity) const noexcept {
    if (intensity <= none) return 0;
    const int over = std::max(0, intensity - zero), low = std::min(over, knee - zero);
    return static_cast<double>(below) * low + static_cast<double>(above) * (over - low);
  }
};

/// Rays from one point to the middles of pixels (i, j): corner + i right + j down. Volume frame.
struct RayFan {
  glm::dvec3 source{0.0}, corner{0.0}, right{0.0}, down{0.0};
  int columns = 0, rows = 0;

  glm::dvec3 pixel(double i, double j) const noexcept { return corner + i * right + j * down; }
  /// The axis across whose slabs the ray to a pixel is summed up: that along which the middle ray of its
  /// packet of eight goes most.
  int slab_axis(int i, int j) const noexcept {
    const glm::dvec3 along = glm::abs(pixel(std::min((i & ~7) + 3.5, columns - 1.0), j) - source);
    return along.x > along.y ? (along.x > along.z ? 0 : 2) : (along.y > along.z ? 1 : 2);
  }
};
/// Pixels low .. high - 1.
struct PixelBox {
  int column_low = 0, row_low = 0, column_high = 0, row_high = 0;
  bool is_empty() const noexcept { return column_low >= column_high || row_low >= row_high; }
};

/// Method of the sum.
enum class RaySum : std::uint8_t { exact, joseph };

/// Sums weight(voxel) over the part of a ray between two of its parameters (of 0 .. 1) that lies in a box of
/// voxels, times how much of the parameter passes there; exactly, in double precision. Coordinates below
/// k_traversal_limit. Adjacent boxes sum up to what one box of both does.
template <class Weight>
double sum_along(const Ray& ray, double from, double to, const VoxelBox& box, const Weight& weight) noexcept;

class LineIntegrals {
 public:
  /// Borrows the volume. One pass over it: which blocks of 8 x 8 x 8 voxels count nothing. threads 0 = all.
  LineIntegrals(const Volume& volume, const VoxelWeights& weights, int threads = 0,
                const LineKernels& kernels = best_line_kernels());

  /// The integral of the weights over each ray from the source (0) to its pixel (1), by rows of the whole
  /// fan; of the box alone. To be multiplied by the ray's length, mm. A ray that lies in a plane between
  /// voxels counts those of the higher side, as in volume/traversal.h. Skipping empty blocks changes no bit;
  /// nor does the number of threads. The exact sums are within 1e-6 of those in exact arithmetic, relative to
  /// the larger of the sum and what a step (1 voxel) of the volume's heaviest voxel counts.
  /// Nothing is summed where coordinates are not finite or beyond k_traversal_limit.
  void integrate(const RayFan& fan, const PixelBox& box, RaySum how, int threads,
                 std::span<double> sums) const;
  /// The exact sum of one ray between two of its parameters, in double precision.
  double integrate(const Ray& ray, double from = 0, double to = 1) const noexcept;

  const VoxelWeights& weights() const noexcept { return weights_; }
  /// Is any voxel of the block (voxel >> 3) counted?
  bool is_filled(const glm::ivec3& block) const noexcept {
    return views_[2].bits[views_[2].word(block.z, block.y, block.x >> 6)] >> (block.x & 63) & 1u;
  }
  const glm::ivec3& blocks() const noexcept { return blocks_; }

 private:
  /// The volume as slabs across one axis, with the bits of its blocks.
  struct View {
    int d = 0, a = 0, b = 0;  ///< axes
    SlabVolume slabs{};
    int size_d = 0, words = 0, rows = 0;
    std::vector<std::uint64_t> bits;  ///< a layer of blocks after another, rows along a

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
  void integrate_tile(const RayFan& fan, const PixelBox& tile, RaySum how, double* sums) const;

  const Volume* volume_;
  VoxelWeights weights_;
  const LineKernels* kernels_;
  glm::ivec3 blocks_;
  std::array<View, 3> views_;
};

template <class Weight>
double sum_along(const Ray& ray, double from, double to, const VoxelBox& box, const Weight& weight) noexcept {
  constexpr double k_never = std::numeric_limits<double>::infinity();
  const glm::dvec3 along = ray.end - ray.start;
  const auto voxel_along = [](double p) noexcept { return voxel_of({p, 0, 0}).x; };
  // Clip at the box's faces.
  double in = from, out = to;
  int entered = -1;
  for (int a = 0; a < 3; ++a) {
    if (along[a] == 0) {
      const int v = voxel_along(ray.start[a]);
      if (v < box.low[a] || v > box.high[a]) return 0;
      continue;
    }
    const double low = (box.low[a] - 0.5 - ray.start[a]) / along[a],
                 high = (box.high[a] + 0.5 - ray.start[a]) / along[a];
    if (std::min(low, high) > in) in = std::min(low, high), entered = a;
    out = std::min(out, std::max(low, high));
  }
  if (!(in < out)) return 0;
  glm::ivec3 voxel, step{0};
  glm::dvec3 next{k_never};  // where the next plane along each axis is crossed
  const auto plane_at = [&](int a) { return (voxel[a] + 0.5 * step[a] - ray.start[a]) / along[a]; };
  for (int a = 0; a < 3; ++a) {
    step[a] = along[a] > 0 ? 1 : along[a] < 0 ? -1 : 0;
    if (step[a] == 0) {
      voxel[a] = voxel_along(ray.start[a]);
      continue;
    }
    voxel[a] = a == entered ? (step[a] > 0 ? box.low[a] : box.high[a])
                            : std::clamp(voxel_along(ray.start[a] + in * along[a]), box.low[a], box.high[a]);
    next[a] = plane_at(a);
    // A plane that rounding put behind is still ahead.
    while (next[a] <= in && voxel[a] + step[a] >= box.low[a] && voxel[a] + step[a] <= box.high[a])
      voxel[a] += step[a], next[a] = plane_at(a);
  }
  double sum = 0, t = in;
  for (;;) {
    const int a = next.x < next.y ? (next.x < next.z ? 0 : 2) : (next.y < next.z ? 1 : 2);
    const double end = std::min(next[a], out);
    if (end > t) sum += (end - t) * weight(voxel), t = end;
    if (next[a] >= out) return sum;
    voxel[a] += step[a];
    if (voxel[a] < box.low[a] || voxel[a] > box.high[a]) return sum;
    next[a] = plane_at(a);
  }
}

}  // namespace trephine::volume
