#include "volume/imaging/line_integrals.h"

#include <cassert>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "volume/base/parallel.h"

namespace trephine::volume {

using glm::dvec2;
using glm::dvec3;
using glm::ivec3;

namespace {

constexpr int k_block = 8;  // voxels along a block's edge, slabs in a layer
constexpr int k_tile_columns = 64, k_tile_rows = 16;
// Slope in voxels per slab. Rays of smaller slope that meet a plane between voxels are integrated
// individually, in double precision.
constexpr double k_shallow = 0x1p-13;
constexpr double k_near = 1e-9;                             // voxels; rays nearer to a plane may be in it
constexpr std::size_t k_max_voxels = std::size_t{1} << 31;  // larger volumes are integrated ray by ray
constexpr double k_far = 0x1p18;                            // voxels; beyond this, fractions lose digits

bool is_traceable(const dvec3& p) noexcept {
  for (int a = 0; a < 3; ++a)
    if (!(std::abs(p[a]) < k_traversal_limit)) return false;
  return true;
}

/// Integral of one ray by Joseph's method, in double precision.
double joseph(const Volume& volume, const VoxelWeights& weights, const Ray& ray) noexcept {
  const dvec3 along = ray.end - ray.start, size = glm::abs(along);
  const int d = size.x > size.y ? (size.x > size.z ? 0 : 2) : (size.y > size.z ? 1 : 2);
  if (size[d] == 0) return 0;
  const int a = d == 0 ? 1 : 0, b = d == 2 ? 1 : 2;
  const auto clamped = [&](double p) {
    return static_cast<int>(std::clamp(p, -1.0, static_cast<double>(volume.size[d])));
  };
  const int first = std::max(0, clamped(std::ceil(std::min(ray.start[d], ray.end[d])))),
            last = std::min(volume.size[d] - 1, clamped(std::floor(std::max(ray.start[d], ray.end[d]))));
  double sum = 0;
  for (int k = first; k <= last; ++k) {
    const dvec3 p = ray.start + (k - ray.start[d]) / along[d] * along;
    const dvec2 floor_of{std::floor(p[a]), std::floor(p[b])}, share = dvec2(p[a], p[b]) - floor_of;
    for (int corner = 0; corner < 4; ++corner) {
      const dvec2 at = floor_of + dvec2(corner & 1, corner >> 1);
      if (!(at.x >= 0 && at.y >= 0 && at.x < volume.size[a] && at.y < volume.size[b])) continue;
      ivec3 v;
      v[d] = k, v[a] = static_cast<int>(at.x), v[b] = static_cast<int>(at.y);
      sum += (corner & 1 ? share.x : 1 - share.x) * (corner >> 1 ? share.y : 1 - share.y) *
             weights.of(volume.voxels[volume.index(v.x, v.y, v.z)]);
    }
  }
  return sum / size[d];
}

}  // namespace

LineIntegrals::LineIntegrals(const Volume& volume, const VoxelWeights& weights, int threads,
                             const LineKernels& kernels)
    : volume_(&volume),
      weights_(weights),
      kernels_(&kernels),
      blocks_((volume.size + k_block - 1) / k_block) {
  const std::int64_t stride[3] = {1, volume.size.x, static_cast<std::int64_t>(volume.size.x) * volume.size.y};
  for (int d = 0; d < 3; ++d) {
    View& view = views_[static_cast<std::size_t>(d)];
    view.d = d, view.a = d == 0 ? 1 : 0, view.b = d == 2 ? 1 : 2;
    view.size_d = volume.size[d];
    view.slabs.voxels = volume.voxels.data();
    view.slabs.stride_d = stride[d];
    view.slabs.stride_a = static_cast<std::int32_t>(stride[view.a]);
    view.slabs.stride_b = static_cast<std::int32_t>(stride[view.b]);
    view.slabs.size_a = volume.size[view.a], view.slabs.size_b = volume.size[view.b];
    view.slabs.last = static_cast<std::int32_t>((view.slabs.size_a - 1) * stride[view.a] +
                                                (view.slabs.size_b - 1) * stride[view.b]);
    view.slabs.highest_weightless = weights.highest_weightless;
    view.slabs.zero = weights.zero, view.slabs.knee_above = weights.knee - weights.zero;
    view.slabs.below = weights.below, view.slabs.above = weights.above;
    view.words = (blocks_[view.a] + 63) / 64, view.rows = blocks_[view.b];
    view.bits.resize(static_cast<std::size_t>(blocks_[d]) * static_cast<std::size_t>(view.rows) *
                     static_cast<std::size_t>(view.words));
  }
  find_filled(threads);
}

void LineIntegrals::find_filled(int threads) {
  std::vector<std::uint8_t> filled(static_cast<std::size_t>(blocks_.x) * static_cast<std::size_t>(blocks_.y) *
                                   static_cast<std::size_t>(blocks_.z));
  const auto index_of = [&](int x, int y, int z) {
    return static_cast<std::size_t>(x) +
           static_cast<std::size_t>(blocks_.x) *
               (static_cast<std::size_t>(y) +
                static_cast<std::size_t>(blocks_.y) * static_cast<std::size_t>(z));
  };
  const ivec3 size = volume_->size;
  parallel_for(blocks_.z, threads, [&](int bz) {
    std::vector<std::int16_t> maximum(static_cast<std::size_t>(size.x));
    for (int by = 0; by < blocks_.y; ++by) {
      std::fill(maximum.begin(), maximum.end(), std::numeric_limits<std::int16_t>::min());
      for (int z = k_block * bz; z < std::min(k_block * (bz + 1), size.z); ++z)
        for (int y = k_block * by; y < std::min(k_block * (by + 1), size.y); ++y) {
          const std::int16_t* row = volume_->voxels.data() + volume_->index(0, y, z);
          for (std::size_t x = 0; x < maximum.size(); ++x) maximum[x] = std::max(maximum[x], row[x]);
        }
      for (std::size_t x = 0; x < maximum.size(); ++x)
        if (maximum[x] > weights_.highest_weightless)
          filled[index_of(static_cast<int>(x) / k_block, by, bz)] = 1;
    }
  });
  for (View& view : views_) {
    ivec3 block;
    for (block.z = 0; block.z < blocks_.z; ++block.z)
      for (block.y = 0; block.y < blocks_.y; ++block.y)
        for (block.x = 0; block.x < blocks_.x; ++block.x)
          if (filled[index_of(block.x, block.y, block.z)])
            view.bits[view.word(block[view.d], block[view.b], block[view.a] >> 6)] |= std::uint64_t{1}
                                                                                      << (block[view.a] & 63);
  }
}

/// Returns true if all blocks of a layer that meet the box low .. high are empty. Units: voxels, voxel i is
/// the interval [i, i + 1).
bool LineIntegrals::View::is_empty(int layer, const dvec2& low, const dvec2& high) const noexcept {
  const auto clamped = [](double p, int last) {
    return static_cast<int>(std::clamp(std::floor(p), -1.0, static_cast<double>(last) + 1));
  };
  const int a0 = std::max(0, clamped(low.x, slabs.size_a - 1)),
            a1 = std::min(slabs.size_a - 1, clamped(high.x, slabs.size_a - 1)),
            b0 = std::max(0, clamped(low.y, slabs.size_b - 1)),
            b1 = std::min(slabs.size_b - 1, clamped(high.y, slabs.size_b - 1));
  if (a0 > a1 || b0 > b1) return true;
  const int first = a0 / k_block, last = a1 / k_block;
  for (int row = b0 / k_block; row <= b1 / k_block; ++row)
    for (int w = first >> 6; w <= last >> 6; ++w) {
      std::uint64_t filled = bits[word(layer, row, w)];
      if (w == first >> 6) filled &= ~std::uint64_t{0} << (first & 63);
      if (w == last >> 6) filled &= ~std::uint64_t{0} >> (63 - (last & 63));
      if (filled != 0) return false;
    }
  return true;
}

/// Packets of rays of neighbouring pixels, integrated layer by layer, so that their voxels stay in the cache.
struct LineIntegrals::Tile {
  struct Packet {
    RayPacket rays;
    dvec2 first, first_slope, last, last_slope;  ///< coordinates and slopes of the outer rays, not mirrored
    double sums[8] = {};
    std::array<double, 8> scale{};  ///< ray parameter per slab
    std::array<int, 8> column{};    ///< -1: unused lane, or ray integrated individually
    int row = 0;
  };

  /// Computes coordinates in the plane d = 0 and slopes of the four corner rays of a tile; false if these do
  /// not enclose the other rays.
  static bool find_corners(const View& view, const RayFan& fan, const PixelBox& tile,
                           std::array<std::array<dvec2, 2>, 4>& corners) {
    int rising = 0;
    for (std::size_t c = 0; c < 4; ++c) {
      const dvec3 along = fan.pixel(c % 2 == 0 ? tile.column_low : tile.column_high - 1,
                                    c / 2 == 0 ? tile.row_low : tile.row_high - 1) -
                          fan.source;
      const dvec2 slope = dvec2(along[view.a], along[view.b]) / along[view.d];
      if (!(std::abs(slope.x) <= 4 && std::abs(slope.y) <= 4)) return false;
      rising += along[view.d] > 0;
      const dvec2 at =
          dvec2(fan.source[view.a], fan.source[view.b]) + 0.5 - (fan.source[view.d] + 0.5) * slope;
      corners[c] = {at, slope};
    }
    return rising % 4 == 0;  // all in the same direction along d, so they enclose the rays between them
  }

  /// Sets a lane to a ray. Returns false if the ray must be integrated individually.
  static bool set_lane(const View& view, const dvec3& from, const dvec3& to, Packet& packet,
                       std::size_t lane) {
    const dvec3 along = to - from;
    const double high = view.size_d - 0.5;
    if (std::min(from[view.d], to[view.d]) > -0.5 || std::max(from[view.d], to[view.d]) < high) return false;
    const double slope_a = along[view.a] / along[view.d], slope_b = along[view.b] / along[view.d];
    if (!(std::abs(slope_a) <= 1 && std::abs(slope_b) <= 1)) return false;
    const double start = from[view.d] + 0.5;
    const dvec2 at{from[view.a] + 0.5 - start * slope_a, from[view.b] + 0.5 - start * slope_b};
    if (!(std::abs(at.x) < k_far && std::abs(at.y) < k_far)) return false;
    RayPacket& r = packet.rays;
    const auto fill = [&](double p0, double slope, double* p, double* slopes, std::uint32_t* steps,
                          float* pers, std::int32_t* mirrors) {
      // If a ray is almost parallel to a plane and near it, single precision cannot locate the crossing.
      const double p1 = p0 + slope * view.size_d;
      if (std::abs(slope) < k_shallow &&
          std::floor(std::min(p0, p1) - k_near) != std::floor(std::max(p0, p1) + k_near))
        return false;
      const bool is_mirrored = slope < 0;
      p[lane] = is_mirrored ? -p0 : p0;
      slopes[lane] = std::abs(slope);
      steps[lane] = static_cast<std::uint32_t>(std::min(std::abs(slope) * 0x1p32, 0x1p32 - 1));
      pers[lane] = slope != 0 ? static_cast<float>(0x1p-31 / std::abs(slope)) : 0.0f;
      mirrors[lane] = is_mirrored ? -1 : 0;
      return true;
    };
    if (!fill(at.x, slope_a, r.a, r.slope_a, r.step_a, r.per_a, r.mirror_a) ||
        !fill(at.y, slope_b, r.b, r.slope_b, r.step_b, r.per_b, r.mirror_b))
      return false;
    packet.scale[lane] = 1 / std::abs(along[view.d]);
    return true;
  }
};

void LineIntegrals::integrate_tile(const RayFan& fan, const PixelBox& tile, RaySum method,
                                   double* sums) const {
  const auto fan_index = [&](int i, int j) {
    return static_cast<std::size_t>(i) + static_cast<std::size_t>(fan.columns) * static_cast<std::size_t>(j);
  };
  std::array<std::vector<Tile::Packet>, 3> packets;
  // Packets start at every eighth column of the fan, so that the bits of a sum do not depend on the tile.
  for (int j = tile.row_low; j < tile.row_high; ++j)
    for (int i = tile.column_low & ~7; i < tile.column_high; i += 8) {
      const auto d = static_cast<std::size_t>(fan.slab_axis(i, j));
      const View& view = views_[d];
      Tile::Packet packet{};
      packet.column.fill(-1);
      std::size_t first = 8, last = 0;
      packet.row = j;
      // Kernels use 32-bit offsets within a slab.
      const bool fits_kernels =
          view.slabs.size_a > 1 && view.slabs.size_b > 1 && volume_->voxels.size() < k_max_voxels;
      for (std::size_t lane = 0; lane < 8 && i + static_cast<int>(lane) < tile.column_high; ++lane) {
        const int column = i + static_cast<int>(lane);
        if (column < tile.column_low) continue;
        const dvec3 to = fan.pixel(column, j);
        if (!is_traceable(fan.source) || !is_traceable(to)) {
          sums[fan_index(column, j)] = 0;
        } else if (fits_kernels && Tile::set_lane(view, fan.source, to, packet, lane)) {
          packet.column[lane] = column;
          first = std::min(first, lane), last = lane;
        } else if (method == RaySum::exact) {
          sums[fan_index(column, j)] = integrate({fan.source, to});
        } else {
          sums[fan_index(column, j)] = joseph(*volume_, weights_, {fan.source, to});
        }
      }
      if (first > last) continue;
      const auto unmirrored = [&](std::size_t lane, bool is_slope) {
        const RayPacket& r = packet.rays;
        const double a = is_slope ? r.slope_a[lane] : r.a[lane], b = is_slope ? r.slope_b[lane] : r.b[lane];
        return dvec2(r.mirror_a[lane] ? -a : a, r.mirror_b[lane] ? -b : b);
      };
      // Unused lanes repeat the first used lane.
      for (std::size_t lane = 0; lane < 8; ++lane)
        if (packet.column[lane] < 0) {
          RayPacket& r = packet.rays;
          r.a[lane] = r.a[first], r.b[lane] = r.b[first];
          r.slope_a[lane] = r.slope_a[first], r.slope_b[lane] = r.slope_b[first];
          r.step_a[lane] = r.step_a[first], r.step_b[lane] = r.step_b[first];
          r.per_a[lane] = r.per_a[first], r.per_b[lane] = r.per_b[first];
          r.mirror_a[lane] = r.mirror_a[first], r.mirror_b[lane] = r.mirror_b[first];
        }
      packet.first = unmirrored(first, false), packet.first_slope = unmirrored(first, true);
      packet.last = unmirrored(last, false), packet.last_slope = unmirrored(last, true);
      packets[d].push_back(packet);
    }
  for (std::size_t d = 0; d < 3; ++d) {
    if (packets[d].empty()) continue;
    const View& view = views_[d];
    const auto kernel = method == RaySum::exact ? kernels_->exact : kernels_->joseph;
    const double reach = method == RaySum::exact ? 1e-6 : 0.5 + 1e-6;  // voxels read around a ray
    std::array<std::array<dvec2, 2>, 4> corners;
    const bool has_corners = Tile::find_corners(view, fan, tile, corners);
    for (int k = 0, layer = 0; k < view.size_d; k += k_block, ++layer) {
      const int count = std::min(k_block, view.size_d - k);
      const auto box_of = [&](const Tile::Packet& p, dvec2& low, dvec2& high) {
        const dvec2 a = p.first + static_cast<double>(k) * p.first_slope,
                    b = p.last + static_cast<double>(k) * p.last_slope,
                    c = a + static_cast<double>(count) * p.first_slope,
                    e = b + static_cast<double>(count) * p.last_slope;
        low = glm::min(glm::min(a, b), glm::min(c, e)) - reach;
        high = glm::max(glm::max(a, b), glm::max(c, e)) + reach;
      };
      dvec2 low, high;
      if (has_corners) {
        low = dvec2(k_far * 8), high = -low;
        for (const auto& [at, slope] : corners)
          for (const int plane : {k, k + count}) {
            const dvec2 p = at + static_cast<double>(plane) * slope;
            low = glm::min(low, p - reach), high = glm::max(high, p + reach);
          }
        if (view.is_empty(layer, low, high)) continue;
      }
      for (Tile::Packet& packet : packets[d]) {
        box_of(packet, low, high);
        if (view.is_empty(layer, low, high)) continue;
        const bool is_inside =
            low.x >= 1 && low.y >= 1 && high.x < view.slabs.size_a - 1 && high.y < view.slabs.size_b - 1;
        kernel(view.slabs, packet.rays, k, count, is_inside, packet.sums);
      }
    }
    for (const Tile::Packet& packet : packets[d])
      for (std::size_t lane = 0; lane < 8; ++lane)
        if (packet.column[lane] >= 0)
          sums[fan_index(packet.column[lane], packet.row)] = packet.sums[lane] * packet.scale[lane];
  }
}

void LineIntegrals::integrate(const RayFan& fan, const PixelBox& box, RaySum method, int threads,
                              std::span<double> sums) const {
  assert(sums.size() >= static_cast<std::size_t>(fan.columns) * static_cast<std::size_t>(fan.rows));
  if (box.is_empty()) return;
  const int tiles_across = (box.column_high - box.column_low + k_tile_columns - 1) / k_tile_columns,
            tiles_down = (box.row_high - box.row_low + k_tile_rows - 1) / k_tile_rows;
  parallel_for(tiles_across * tiles_down, threads, [&](int n) {
    PixelBox tile;
    tile.column_low = box.column_low + n % tiles_across * k_tile_columns;
    tile.row_low = box.row_low + n / tiles_across * k_tile_rows;
    tile.column_high = std::min(box.column_high, tile.column_low + k_tile_columns);
    tile.row_high = std::min(box.row_high, tile.row_low + k_tile_rows);
    integrate_tile(fan, tile, method, sums.data());
  });
}

double LineIntegrals::integrate(const Ray& ray, double t_begin, double t_end) const noexcept {
  if (!is_traceable(ray.start) || !is_traceable(ray.end) || ray.start == ray.end) return 0;
  return sum_along(ray, t_begin, t_end, {ivec3(0), volume_->size - 1}, [this](const ivec3& v) {
    const std::int16_t intensity = volume_->voxels[volume_->index(v.x, v.y, v.z)];
    return intensity > weights_.highest_weightless ? weights_.of(intensity) : 0.0;
  });
}

}  // namespace trephine::volume
