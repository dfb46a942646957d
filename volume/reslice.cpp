#include "volume/reslice.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstring>
#include <glm/geometric.hpp>
#include <vector>

#include "volume/parallel.h"

namespace trephine::volume {

using glm::dvec3;
using glm::ivec3;

namespace {

constexpr double k_steps = 1 << 20;           // a voxel
constexpr int k_tile = 64, k_tile_rows = 16;  // pixels that a thread does at once
constexpr int k_most = 2046;                  // voxels along an edge for places in 2^-20

float between(float a, float b, float share) noexcept { return a + share * (b - a); }

/// The same operations as the wide code's.
void row_any(const ResliceRow& row, int count, float* values) {
  std::uint32_t at[3];
  for (int a = 0; a < 3; ++a) at[a] = static_cast<std::uint32_t>(row.at[a]);
  for (int i = 0; i < count; ++i) {
    float share[3];
    for (int a = 0; a < 3; ++a) share[a] = static_cast<float>(at[a] & ((1u << 20) - 1)) * 0x1p-20f;
    const std::int16_t* v = row.voxels + (at[0] >> 20) +
                            static_cast<std::ptrdiff_t>(at[1] >> 20) * row.stride_y +
                            static_cast<std::ptrdiff_t>(at[2] >> 20) * row.stride_z;
    const auto along_x = [&](const std::int16_t* from) {
      return between(static_cast<float>(from[0]), static_cast<float>(from[1]), share[0]);
    };
    const float near = between(along_x(v), along_x(v + row.stride_y), share[1]);
    const float far = between(along_x(v + row.stride_z), along_x(v + row.stride_z + row.stride_y), share[1]);
    values[i] = between(near, far, share[2]);
    for (int a = 0; a < 3; ++a) at[a] += static_cast<std::uint32_t>(row.step[a]);
  }
}

/// A pixel near the border or beyond it; false: outside.
bool at_border(const Volume& v, const dvec3& p, float& value) noexcept {
  dvec3 share;
  ivec3 low, high;
  for (int a = 0; a < 3; ++a) {
    if (!(p[a] >= -0.5 && p[a] <= v.size[a] - 0.5)) return false;
    const double clamped = std::clamp(p[a], 0.0, v.size[a] - 1.0);
    low[a] = std::min(static_cast<int>(clamped), std::max(0, v.size[a] - 2));
    high[a] = std::min(low[a] + 1, v.size[a] - 1);
    share[a] = clamped - low[a];
  }
  double sum = 0;
  for (int corner = 0; corner < 8; ++corner) {
    double weight = 1;
    ivec3 at;
    for (int a = 0; a < 3; ++a) {
      const bool is_high = corner >> a & 1;
      at[a] = is_high ? high[a] : low[a];
      weight *= is_high ? share[a] : 1 - share[a];
    }
    sum += weight * v.voxels[v.index(at.x, at.y, at.z)];
  }
  value = static_cast<float>(sum);
  return true;
}

std::int16_t rounded(float value) noexcept {
  return static_cast<std::int16_t>(std::clamp(std::floor(value + 0.5f), -32768.0f, 32767.0f));
}

/// Voxels as rows are sampled of them: those of the volume, or a copy of a few, from `low` on.
struct Window {
  const std::int16_t* voxels;
  std::int32_t stride_y, stride_z;
  ivec3 low{0};
};

/// The pixels begin .. end - 1 of a row from p on lie with all eight voxels in the grid: a stretch without
/// gaps of a multiple of eight. The last voxel is not read as the first of a pair.
struct Stretch {
  int begin = 0, end = 0;
  ResliceRow row;
};
Stretch stretch_of(const Volume& v, const Window& window, const dvec3& p, const dvec3& step, int count) {
  Stretch stretch;
  double first = 0, last = count - 1;
  const double margin = 2 / k_steps * (count + 2);
  bool is_any = v.size.x > 2 && v.size.y > 2 && v.size.z > 2 && v.size.x <= k_most && v.size.y <= k_most &&
                v.size.z <= k_most && v.voxels.size() < std::size_t{1} << 31;
  for (int a = 0; a < 3 && is_any; ++a) {
    const double high = v.size[a] - 1.0 - margin;
    if (std::abs(step[a]) < 1e-12) {
      is_any = p[a] >= margin && p[a] < high;
      continue;
    }
    const double s = (margin - p[a]) / step[a], t = (high - p[a]) / step[a];
    first = std::max(first, std::min(s, t)), last = std::min(last, std::max(s, t));
  }
  if (!is_any || !(first <= last)) return stretch;
  stretch.begin = static_cast<int>(std::ceil(first));
  stretch.end = stretch.begin + (std::max(0, static_cast<int>(std::floor(last)) - stretch.begin + 1) & ~7);
  stretch.row = {window.voxels, window.stride_y, window.stride_z, {}, {}};
  for (int a = 0; a < 3; ++a) {
    stretch.row.at[a] =
        static_cast<std::int32_t>(std::lround((p[a] - window.low[a] + stretch.begin * step[a]) * k_steps));
    stretch.row.step[a] = static_cast<std::int32_t>(std::lround(step[a] * k_steps));
  }
  return stretch;
}

/// A row of pixels from p on, in one plane: values, and NaN outside.
void sample_row(const Volume& v, const Window& window, const dvec3& p, const dvec3& step, int count,
                ResliceCode code, float* values) {
  const Stretch stretch = stretch_of(v, window, p, step, count);
  for (int i = 0; i < count; ++i) {
    if (i == stretch.begin && stretch.begin < stretch.end) {
      if (code == ResliceCode::wide)
        reslice_row_wide(stretch.row, stretch.end - i, values + i);
      else
        row_any(stretch.row, stretch.end - i, values + i);
      i = stretch.end - 1;
      continue;
    }
    if (!at_border(v, p + static_cast<double>(i) * step, values[i])) values[i] = std::nanf("");
  }
}

/// The same as pixels.
void show_row(const Volume& v, const Window& window, const dvec3& p, const dvec3& step, int count,
              ResliceCode code, std::int16_t outside, std::int16_t* pixels) {
  const Stretch stretch = stretch_of(v, window, p, step, count);
  for (int i = 0; i < count; ++i) {
    if (i == stretch.begin && stretch.begin < stretch.end) {
      const int inside = stretch.end - i;
      if (code == ResliceCode::wide) {
        reslice_row_wide(stretch.row, inside, pixels + i);
      } else {
        std::array<float, k_tile> values;
        row_any(stretch.row, inside, values.data());
        for (int k = 0; k < inside; ++k) pixels[i + k] = rounded(values[static_cast<std::size_t>(k)]);
      }
      i = stretch.end - 1;
      continue;
    }
    float value = 0;
    pixels[i] = at_border(v, p + static_cast<double>(i) * step, value) ? rounded(value) : outside;
  }
}

/// The few voxels that a tile of a plane along an axis reads, side by side: their own places, a power of two
/// apart, would all fall on the same lines of a cache. False: they are not few.
bool copy_window(const Volume& v, const dvec3& corner, const dvec3& right, const dvec3& down, int columns,
                 int rows, std::array<std::int16_t, 4096>& copy, Window& window) {
  const dvec3 a = corner + (columns - 1.0) * right, b = corner + (rows - 1.0) * down, c = a + b - corner;
  ivec3 low, high;
  for (int axis = 0; axis < 3; ++axis) {
    const double least = std::min({corner[axis], a[axis], b[axis], c[axis]}),
                 most = std::max({corner[axis], a[axis], b[axis], c[axis]});
    if (!(least > -1e6 && most < 1e6)) return false;
    low[axis] = std::clamp(static_cast<int>(std::floor(least)) - 1, 0, v.size[axis] - 1);
    high[axis] = std::clamp(static_cast<int>(std::floor(most)) + 2, 0, v.size[axis] - 1);
  }
  ivec3 size = high - low + 1;
  const bool is_thin = size.x <= 4 && v.size.x >= 4;
  if (is_thin) size.x = 4, low.x = std::min(low.x, v.size.x - 4);
  if (static_cast<std::int64_t>(size.x) * size.y * size.z >= static_cast<std::int64_t>(copy.size()))
    return false;
  std::int16_t* to = copy.data();
  for (int z = low.z; z <= high.z; ++z) {
    const std::int16_t* from = v.voxels.data() + v.index(low.x, low.y, z);
    for (int y = low.y; y <= high.y; ++y, to += size.x, from += v.size.x)
      if (is_thin)
        std::memcpy(to, from, 4 * sizeof(std::int16_t));
      else
        std::copy_n(from, size.x, to);
  }
  window = {copy.data(), size.x, size.x * size.y, low};
  return true;
}

/// Asks for what a tile will read, where its rows do not lie along the voxels': a place a voxel.
void fetch_tile(const Volume& v, const dvec3& corner, const dvec3& right, const dvec3& down, int columns,
                int rows) {
  const auto steps = [](const dvec3& step) {
    return std::max(
        1, static_cast<int>(1 / std::max({std::abs(step.x) / 16, std::abs(step.y), std::abs(step.z), 1e-3})));
  };
  const int by_column = steps(right), by_row = steps(down);
  const std::int64_t stride_y = v.size.x, stride_z = stride_y * v.size.y;
  std::int64_t to_right[3], to_down[3], at[3], last[3];
  for (int a = 0; a < 3; ++a) {
    to_right[a] = std::lround(by_column * right[a] * k_steps),
    to_down[a] = std::lround(by_row * down[a] * k_steps);
    at[a] = std::lround(corner[a] * k_steps), last[a] = (v.size[a] - 1) * (std::int64_t{1} << 20);
  }
  for (int j = 0; j < rows; j += by_row) {
    std::int64_t x = at[0], y = at[1], z = at[2];
    for (int i = 0; i < columns; i += by_column) {
      if (x >= 0 && y >= 0 && z >= 0 && x <= last[0] && y <= last[1] && z <= last[2])
        __builtin_prefetch(v.voxels.data() + (x >> 20) + (y >> 20) * stride_y + (z >> 20) * stride_z);
      x += to_right[0], y += to_right[1], z += to_right[2];
    }
    for (int a = 0; a < 3; ++a) at[a] += to_down[a];
  }
}

/// Bands of the image, each by one thread, tile by tile: neighbours read the same voxels.
/// use(column, row, columns, rows) for each; next(...) of the one that comes after it in the band, before.
template <class Next, class Use>
void for_tiles(const ImagePlane& plane, int threads, const Next& next, const Use& use) {
  parallel_for((plane.rows + k_tile_rows - 1) / k_tile_rows, threads, [&](int band) {
    const int row = band * k_tile_rows, rows = std::min(k_tile_rows, plane.rows - row);
    for (int column = 0; column < plane.columns; column += k_tile) {
      if (const int after = column + k_tile; after < plane.columns)
        next(after, row, std::min(k_tile, plane.columns - after), rows);
      use(column, row, std::min(k_tile, plane.columns - column), rows);
    }
  });
}

}  // namespace

ResliceCode best_reslice_code() noexcept {
  return __builtin_cpu_supports("avx2") ? ResliceCode::wide : ResliceCode::any;
}

void reslice(const Volume& volume, const ImagePlane& plane, const Slab& slab, std::int16_t outside,
             int threads, std::span<std::int16_t> pixels, ResliceCode code) {
  assert(pixels.size() >= static_cast<std::size_t>(plane.columns) * static_cast<std::size_t>(plane.rows));
  const Frame& frame = volume.frame;
  const double least = std::min({frame.spacing().x, frame.spacing().y, frame.spacing().z});
  const int layers = slab.thickness > 0 ? 1 + static_cast<int>(std::ceil(2 * slab.thickness / least)) : 1;
  const dvec3 step = frame.vector_volume_from_world(plane.pixel * plane.right);
  const dvec3 down = frame.vector_volume_from_world(-plane.pixel * plane.up);
  const bool is_scattered = std::abs(step.x) < 0.9 * glm::length(step);
  const auto fetch = [&](int column, int row, int columns, int rows) {
    if (is_scattered && layers == 1)
      fetch_tile(volume, frame.volume_from_world(plane.world(column, row)), step, down, columns, rows);
  };
  const Window all{volume.voxels.data(), volume.size.x, volume.size.x * volume.size.y};
  for_tiles(plane, threads, fetch, [&](int column, int first_row, int count, int rows) {
    std::array<float, k_tile> values, sums, counts;
    std::array<std::int16_t, 4096> copy;
    Window window = all;
    if (is_scattered && layers == 1)
      copy_window(volume, frame.volume_from_world(plane.world(column, first_row)), step, down, count, rows,
                  copy, window);
    for (int row = first_row; row < first_row + rows; ++row) {
      std::int16_t* out = pixels.data() + static_cast<std::size_t>(column) +
                          static_cast<std::size_t>(plane.columns) * static_cast<std::size_t>(row);
      const dvec3 first = frame.volume_from_world(plane.world(column, row));
      if (layers == 1) {
        show_row(volume, window, first, step, count, code, outside, out);
        continue;
      }
      sums.fill(0), counts.fill(0);
      for (int layer = 0; layer < layers; ++layer) {
        const double off = slab.thickness * (layer / (layers - 1.0) - 0.5);
        const dvec3 p = first + frame.vector_volume_from_world(off * plane.normal());
        sample_row(volume, all, p, step, count, code, values.data());
        for (std::size_t i = 0; i < static_cast<std::size_t>(count); ++i) {
          if (std::isnan(values[i])) continue;
          if (slab.kind == Slab::Kind::mean)
            sums[i] += values[i];
          else
            sums[i] = counts[i] > 0 ? std::max(sums[i], values[i]) : values[i];
          counts[i] += 1;
        }
      }
      for (std::size_t i = 0; i < static_cast<std::size_t>(count); ++i)
        out[i] =
            counts[i] > 0 ? rounded(slab.kind == Slab::Kind::mean ? sums[i] / counts[i] : sums[i]) : outside;
    }
  });
}

void reslice_cuts(const Version& version, const ImagePlane& plane, std::int16_t air, int threads,
                  std::span<std::int16_t> pixels) {
  if (version.is_untouched()) return;
  const Frame& frame = version.base().frame;
  const double soft = std::min(
      {0.5 * std::max({frame.spacing().x, frame.spacing().y, frame.spacing().z}), 0.9 * version.band_mm()});
  for_tiles(
      plane, threads, [](int, int, int, int) {},
      [&](int column, int first_row, int count, int rows) {
        for (int row = first_row; row < first_row + rows; ++row)
          for (int i = column; i < column + count; ++i) {
            const dvec3 p = frame.volume_from_world(plane.world(i, row));
            if (!version.is_near_cut(p)) continue;
            std::int16_t& pixel =
                pixels[static_cast<std::size_t>(i) +
                       static_cast<std::size_t>(plane.columns) * static_cast<std::size_t>(row)];
            const double kept = std::clamp(0.5 + 0.5 * version.distance(p) / soft, 0.0, 1.0);
            pixel = static_cast<std::int16_t>(std::floor(air + kept * (pixel - air) + 0.5));
          }
      });
}

}  // namespace trephine::volume
