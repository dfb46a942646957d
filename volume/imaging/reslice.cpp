#include "volume/imaging/reslice.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstring>
#include <glm/geometric.hpp>
#include <vector>

#include "volume/base/cpu.h"
#include "volume/base/parallel.h"

namespace trephine::volume {

using glm::dvec3;
using glm::ivec3;

namespace {

// Positions along a row are integers: of 64 bits in units of 2^-40 of a voxel for the whole row, and of 32
// bits in units of 2^-20 of a voxel within a tile.
constexpr double k_steps = 1 << 20;                      // fixed-point units per voxel
constexpr int k_tile = 64, k_tile_rows = 16;             // pixels of a tile
constexpr int k_longest = 2046;                          // voxels along an edge, limit of 32-bit positions
constexpr double k_farthest = 1 << 20;                   // voxels, limit of 64-bit positions
constexpr double k_margin = 2 / k_steps * (k_tile + 2);  // voxels, rounding error accumulated over a tile

float between(float a, float b, float share) noexcept { return a + share * (b - a); }

/// Performs the operations of the wide code for one pixel at a time.
void row_any(const ResliceRow& row, int count, float* values) {
  std::uint32_t at[3];
  for (int a = 0; a < 3; ++a) at[a] = static_cast<std::uint32_t>(row.at[a]);
  for (int i = 0; i < count; ++i) {
    float share[3];
    for (int a = 0; a < 3; ++a) share[a] = static_cast<float>(at[a] & ((1u << 20) - 1)) * 0x1p-20f;
    const std::ptrdiff_t first = static_cast<std::ptrdiff_t>(at[1] >> 20) * row.stride_y +
                                 static_cast<std::ptrdiff_t>(at[2] >> 20) * row.stride_z;
    const auto along_x = [&](std::ptrdiff_t from) {
      if (row.sheet != nullptr) return row.sheet[from];
      const std::int16_t* v = row.voxels + (at[0] >> 20) + from;
      return between(static_cast<float>(v[0]), static_cast<float>(v[1]), share[0]);
    };
    const auto along_y = [&](std::ptrdiff_t from) {
      return between(along_x(from), along_x(from + row.stride_y), share[1]);
    };
    values[i] = between(along_y(first), along_y(first + row.stride_z), share[2]);
    for (int a = 0; a < 3; ++a) at[a] += static_cast<std::uint32_t>(row.step[a]);
  }
}

/// Samples one pixel, at the border of the volume too, in double precision; false if it is outside.
bool sample_at_border(const Volume& v, const dvec3& p, float& value) noexcept {
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

/// Source of samples for rows: the volume, a copy of some voxels, or a sheet, starting at voxel `low`.
struct Window {
  const std::int16_t* voxels;
  const float* sheet;
  std::int32_t stride_y, stride_z;
  ivec3 low{0};
};

/// Row of the image, or of a layer of a slab.
struct Line {
  dvec3 first;  ///< position of pixel 0, voxels
  /// All eight voxels around pixels begin .. end - 1 are in the grid; along each axis the lower of two voxels
  /// is never the last voxel of the grid.
  int begin = 0, end = 0;
  std::int64_t at[3], step[3];  ///< position of pixel 0 and step per pixel, in 2^-40 of a voxel
};
Line line_of(const Volume& v, const dvec3& p, const dvec3& step, int count) {
  Line line;
  line.first = p;
  double first = 0, last = count - 1;
  bool is_representable = v.size.x > 2 && v.size.y > 2 && v.size.z > 2 && v.size.x <= k_longest &&
                          v.size.y <= k_longest && v.size.z <= k_longest &&
                          v.voxels.size() < std::size_t{1} << 31;
  for (int a = 0; a < 3 && is_representable; ++a) {
    const double high = v.size[a] - 1.0 - k_margin;
    is_representable = std::abs(p[a]) < k_farthest && std::abs(step[a]) * count < k_farthest;
    if (std::abs(step[a]) < 1e-12) {
      is_representable = is_representable && p[a] >= k_margin && p[a] < high;
      continue;
    }
    const double s = (k_margin - p[a]) / step[a], t = (high - p[a]) / step[a];
    first = std::max(first, std::min(s, t)), last = std::min(last, std::max(s, t));
  }
  if (!is_representable || !(first <= last)) return line;
  line.begin = static_cast<int>(std::ceil(first)), line.end = static_cast<int>(std::floor(last)) + 1;
  for (int a = 0; a < 3; ++a)
    line.at[a] = std::llround(p[a] * k_steps * k_steps),
    line.step[a] = std::llround(step[a] * k_steps * k_steps);
  return line;
}

/// Visits the pixels column .. column + count - 1 of a line. Calls inside(begin, end, row) for a range of
/// pixels inside the grid, whose length is a multiple of eight, and border(i, position) for each pixel
/// outside this range.
template <class Inside, class Border>
void for_pixels(const Line& line, const dvec3& step, const Window& window, int column, int count,
                const Inside& inside, const Border& border) {
  const int begin = std::clamp(line.begin - column, 0, count),
            end = begin + (std::max(0, std::min(line.end - column, count) - begin) & ~7);
  if (begin < end) {
    ResliceRow row{window.voxels, window.sheet, window.stride_y, window.stride_z, {}, {}};
    for (int a = 0; a < 3; ++a) {
      row.at[a] = static_cast<std::int32_t>((line.at[a] + (column + begin) * line.step[a]) >> 20) -
                  (window.low[a] << 20);
      row.step[a] = static_cast<std::int32_t>((line.step[a] + (1 << 19)) >> 20);
    }
    inside(begin, end, row);
  }
  for (int i = 0; i < count; ++i)
    if (i == begin && begin < end)
      i = end - 1;
    else
      border(i, line.first + static_cast<double>(column + i) * step);
}

/// Samples pixels as floats; NaN outside.
void sample(const Volume& v, const Line& line, const dvec3& step, const Window& window, int column, int count,
            ResliceCode code, float* values) {
  for_pixels(
      line, step, window, column, count,
      [&](int begin, int end, const ResliceRow& row) {
        if (code == ResliceCode::wide)
          reslice_row_wide(row, end - begin, values + begin);
        else
          row_any(row, end - begin, values + begin);
      },
      [&](int i, const dvec3& p) {
        if (!sample_at_border(v, p, values[i])) values[i] = std::nanf("");
      });
}

/// Samples pixels as rounded intensities.
void sample_rounded(const Volume& v, const Line& line, const dvec3& step, const Window& window, int column,
                    int count, ResliceCode code, std::int16_t outside, std::int16_t* pixels) {
  for_pixels(
      line, step, window, column, count,
      [&](int begin, int end, const ResliceRow& row) {
        if (code == ResliceCode::wide) {
          reslice_row_wide(row, end - begin, pixels + begin);
          return;
        }
        std::array<float, k_tile> values;
        row_any(row, end - begin, values.data());
        for (int i = begin; i < end; ++i) pixels[i] = rounded(values[static_cast<std::size_t>(i - begin)]);
      },
      [&](int i, const dvec3& p) {
        float value = 0;
        pixels[i] = sample_at_border(v, p, value) ? rounded(value) : outside;
      });
}

/// Computes the box of voxels around a parallelogram of pixels, enlarged by one voxel on each side and
/// clamped to the volume. Returns false if a coordinate of a pixel exceeds k_farthest.
bool box_of(const Volume& v, const dvec3& corner, const dvec3& to_right, const dvec3& to_below, ivec3& low,
            ivec3& high) {
  const dvec3 a = corner + to_right, b = corner + to_below, c = a + to_below;
  for (int axis = 0; axis < 3; ++axis) {
    const double lowest = std::min({corner[axis], a[axis], b[axis], c[axis]}),
                 highest = std::max({corner[axis], a[axis], b[axis], c[axis]});
    if (!(lowest > -k_farthest && highest < k_farthest)) return false;
    low[axis] = std::clamp(static_cast<int>(std::floor(lowest)) - 1, 0, v.size[axis] - 1);
    high[axis] = std::clamp(static_cast<int>(std::floor(highest)) + 2, 0, v.size[axis] - 1);
  }
  return true;
}

/// Interpolates the volume along x for a plane of constant x. Each cache line contains only two voxels that
/// such a plane needs; the sheet reads each line once and in order. Returns an empty sheet if the plane has
/// another orientation, or fewer pixels than the sheet has voxels.
std::vector<float> make_sheet(const Volume& v, const ImagePlane& plane, const dvec3& step, const dvec3& down,
                              int threads, Window& window) {
  std::vector<float> sheet;
  const dvec3 corner = v.frame.volume_from_world(plane.world(0, 0));
  ivec3 low, high;
  if (std::abs(step.x) >= 1e-12 || std::abs(down.x) >= 1e-12 ||
      !(corner.x >= k_margin && corner.x < v.size.x - 1 - k_margin) ||
      !box_of(v, corner, (plane.columns - 1.0) * step, (plane.rows - 1.0) * down, low, high))
    return sheet;
  const ivec3 size = high - low + 1;
  if (static_cast<std::int64_t>(size.y) * size.z > static_cast<std::int64_t>(plane.columns) * plane.rows)
    return sheet;
  sheet.resize(static_cast<std::size_t>(size.y) * static_cast<std::size_t>(size.z));
  const auto x = static_cast<std::uint32_t>(std::llround(corner.x * k_steps));
  const float share = static_cast<float>(x & ((1u << 20) - 1)) * 0x1p-20f;
  parallel_for(size.z, threads, [&](int z) {
    float* row = sheet.data() + static_cast<std::ptrdiff_t>(z) * size.y;
    const std::int16_t* from = v.voxels.data() + v.index(static_cast<int>(x >> 20), low.y, low.z + z);
    for (int y = 0; y < size.y; ++y, from += v.size.x) {
      __builtin_prefetch(from + 16 * static_cast<std::ptrdiff_t>(v.size.x));
      row[y] = between(static_cast<float>(from[0]), static_cast<float>(from[1]), share);
    }
  });
  window = {nullptr, sheet.data(), 1, size.y, {0, low.y, low.z}};
  return sheet;
}

/// Copies the voxels that a tile reads, and sets `window` to the copy. Returns false if they do not fit into
/// the copy. In a volume whose strides are powers of two, these voxels would compete for the same lines of
/// the cache.
bool copy_window(const Volume& v, const dvec3& corner, const dvec3& right, const dvec3& down, int columns,
                 int rows, std::array<std::int16_t, 4096>& copy, Window& window) {
  ivec3 low, high;
  if (!box_of(v, corner, (columns - 1.0) * right, (rows - 1.0) * down, low, high)) return false;
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
  window = {copy.data(), nullptr, size.x, size.x * size.y, low};
  return true;
}

/// Prefetches the voxels of a tile whose rows are not parallel to rows of voxels: one address per voxel, or
/// per cache line along x.
void prefetch_tile(const Volume& v, const dvec3& corner, const dvec3& right, const dvec3& down, int columns,
                   int rows) {
  const auto address_count = [](const dvec3& step, int pixels) {
    const double voxels = pixels * std::max({std::abs(step.x) / 32, std::abs(step.y), std::abs(step.z)});
    return std::clamp(static_cast<int>(std::ceil(voxels)), 1, pixels);
  };
  const int count_right = address_count(right, columns), count_down = address_count(down, rows);
  const dvec3 step = right * (static_cast<double>(columns) / count_right);
  const std::ptrdiff_t stride_y = v.size.x, stride_z = stride_y * v.size.y;
  std::int64_t increment[3];
  for (int a = 0; a < 3; ++a) increment[a] = std::llround(step[a] * k_steps);
  for (int j = 0; j < count_down; ++j) {
    const dvec3 p = corner + down * (j * static_cast<double>(rows) / count_down),
                q = p + step * static_cast<double>(count_right);
    bool is_inside = true;
    for (int a = 0; a < 3; ++a)
      is_inside = is_inside && std::min(p[a], q[a]) >= 1 && std::max(p[a], q[a]) < v.size[a] - 1;
    if (!is_inside) continue;
    std::int64_t at[3];
    for (int a = 0; a < 3; ++a) at[a] = static_cast<std::int64_t>(p[a] * k_steps);
    for (int i = 0; i < count_right; ++i) {
      __builtin_prefetch(v.voxels.data() + (at[0] >> 20) + (at[1] >> 20) * stride_y +
                         (at[2] >> 20) * stride_z);
      for (int a = 0; a < 3; ++a) at[a] += increment[a];
    }
  }
}

/// Calls use(column, row, columns, rows) for each tile. A thread processes a band of tiles in order, since
/// neighbouring tiles read the same voxels.
template <class Use>
void for_tiles(const ImagePlane& plane, int threads, const Use& use) {
  parallel_for((plane.rows + k_tile_rows - 1) / k_tile_rows, threads, [&](int band) {
    const int row = band * k_tile_rows, rows = std::min(k_tile_rows, plane.rows - row);
    for (int column = 0; column < plane.columns; column += k_tile)
      use(column, row, std::min(k_tile, plane.columns - column), rows);
  });
}

/// Pixel grid of a plane in the frame of a volume.
struct PixelGrid {
  PixelGrid(const Volume& v, const ImagePlane& p)
      : volume(v),
        plane(p),
        step(v.frame.vector_volume_from_world(p.pixel * p.right)),
        down(v.frame.vector_volume_from_world(-p.pixel * p.up)) {}
  /// Position of a pixel's centre, volume frame.
  dvec3 at(int column, int row) const { return volume.frame.volume_from_world(plane.world(column, row)); }
  /// Index of a pixel in the image.
  std::size_t pixel(int column, int row) const {
    return static_cast<std::size_t>(column) +
           static_cast<std::size_t>(plane.columns) * static_cast<std::size_t>(row);
  }
  Window whole_volume() const {
    return {volume.voxels.data(), nullptr, volume.size.x, volume.size.x * volume.size.y};
  }

  const Volume& volume;
  const ImagePlane& plane;
  dvec3 step, down;  ///< steps per column and per row, voxels
};

void reslice_plane(const PixelGrid& grid, std::int16_t outside, int threads, ResliceCode code,
                   std::span<std::int16_t> pixels) {
  const Volume& volume = grid.volume;
  const ImagePlane& plane = grid.plane;
  const dvec3 &step = grid.step, &down = grid.down;
  Window whole = grid.whole_volume();
  const std::vector<float> sheet = make_sheet(volume, plane, step, down, threads, whole);
  const bool is_scattered = sheet.empty() && std::abs(step.x) < 0.9 * glm::length(step);
  parallel_for((plane.rows + k_tile_rows - 1) / k_tile_rows, threads, [&](int band) {
    const int first = band * k_tile_rows, rows = std::min(k_tile_rows, plane.rows - first);
    std::array<Line, k_tile_rows> lines;
    for (int row = 0; row < rows; ++row)
      lines[static_cast<std::size_t>(row)] = line_of(volume, grid.at(0, first + row), step, plane.columns);
    std::array<std::int16_t, 4096> copy;
    for (int column = 0; column < plane.columns; column += k_tile) {
      const int count = std::min(k_tile, plane.columns - column);
      Window window = whole;
      if (is_scattered) {
        if (const int next = column + k_tile; next < plane.columns)
          prefetch_tile(volume, grid.at(next, first), step, down, std::min(k_tile, plane.columns - next),
                        rows);
        copy_window(volume, grid.at(column, first), step, down, count, rows, copy, window);
      }
      for (int row = 0; row < rows; ++row)
        sample_rounded(volume, lines[static_cast<std::size_t>(row)], step, window, column, count, code,
                       outside, pixels.data() + grid.pixel(column, first + row));
    }
  });
}

void reslice_slab(const PixelGrid& grid, const Slab& slab, std::int16_t outside, int threads,
                  ResliceCode code, std::span<std::int16_t> pixels) {
  const Frame& frame = grid.volume.frame;
  const double lowest = std::min({frame.spacing().x, frame.spacing().y, frame.spacing().z});
  const int layers = 1 + static_cast<int>(std::ceil(2 * slab.thickness / lowest));
  for_tiles(grid.plane, threads, [&](int column, int first_row, int count, int rows) {
    std::array<float, k_tile> values, sums, counts;
    for (int row = first_row; row < first_row + rows; ++row) {
      sums.fill(0), counts.fill(0);
      for (int layer = 0; layer < layers; ++layer) {
        const double height = slab.thickness * (layer / (layers - 1.0) - 0.5);
        const dvec3 p = grid.at(column, row) + frame.vector_volume_from_world(height * grid.plane.normal());
        sample(grid.volume, line_of(grid.volume, p, grid.step, count), grid.step, grid.whole_volume(), 0,
               count, code, values.data());
        for (std::size_t i = 0; i < static_cast<std::size_t>(count); ++i) {
          if (std::isnan(values[i])) continue;
          if (slab.kind == Slab::Kind::mean)
            sums[i] += values[i];
          else
            sums[i] = counts[i] > 0 ? std::max(sums[i], values[i]) : values[i];
          counts[i] += 1;
        }
      }
      for (int i = 0; i < count; ++i) {
        const auto k = static_cast<std::size_t>(i);
        pixels[grid.pixel(column + i, row)] =
            counts[k] > 0 ? rounded(slab.kind == Slab::Kind::mean ? sums[k] / counts[k] : sums[k]) : outside;
      }
    }
  });
}

}  // namespace

ResliceCode best_reslice_code() noexcept { return uses_avx2() ? ResliceCode::wide : ResliceCode::any; }

void reslice(const Volume& volume, const ImagePlane& plane, const Slab& slab, std::int16_t outside,
             int threads, std::span<std::int16_t> pixels, ResliceCode code) {
  assert(pixels.size() >= static_cast<std::size_t>(plane.columns) * static_cast<std::size_t>(plane.rows));
  const PixelGrid grid(volume, plane);
  if (slab.thickness > 0)
    reslice_slab(grid, slab, outside, threads, code, pixels);
  else
    reslice_plane(grid, outside, threads, code, pixels);
}

void reslice_cuts(const Version& version, const ImagePlane& plane, std::int16_t air, int threads,
                  std::span<std::int16_t> pixels) {
  if (version.is_uncut()) return;
  const Frame& frame = version.base().frame;
  const double edge_mm = std::min(
      {0.5 * std::max({frame.spacing().x, frame.spacing().y, frame.spacing().z}), 0.9 * version.band_mm()});
  for_tiles(plane, threads, [&](int column, int first_row, int count, int rows) {
    for (int row = first_row; row < first_row + rows; ++row)
      for (int i = column; i < column + count; ++i) {
        const dvec3 p = frame.volume_from_world(plane.world(i, row));
        if (!version.is_near_cut(p)) continue;
        std::int16_t& pixel = pixels[static_cast<std::size_t>(i) +
                                     static_cast<std::size_t>(plane.columns) * static_cast<std::size_t>(row)];
        const double kept = std::clamp(0.5 + 0.5 * version.distance(p) / edge_mm, 0.0, 1.0);
        pixel = static_cast<std::int16_t>(std::floor(air + kept * (pixel - air) + 0.5));
      }
  });
}

}  // namespace trephine::volume
