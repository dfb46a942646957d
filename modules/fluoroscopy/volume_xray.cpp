#include "modules/fluoroscopy/volume_xray.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>

#include "modules/fluoroscopy/mesh_crossings.h"
#include "volume/base/parallel.h"
#include "volume/imaging/image_plane.h"

namespace trephine::fluoroscopy {

using glm::dvec3;
using glm::ivec3;
using volume::PixelBox;
using volume::Ray;

namespace {

bool is_same(const View& a, const View& b) noexcept {
  return a.source == b.source && a.corner == b.corner && a.right == b.right && a.down == b.down &&
         a.columns == b.columns && a.rows == b.rows && a.open.column_low == b.open.column_low &&
         a.open.row_low == b.open.row_low && a.open.column_high == b.open.column_high &&
         a.open.row_high == b.open.row_high;
}

std::size_t index_of(const View& view, int column, int row) noexcept {
  return static_cast<std::size_t>(column) +
         static_cast<std::size_t>(view.columns) * static_cast<std::size_t>(row);
}

double length_of(const View& view, int column, int row) noexcept {
  return glm::length(view.pixel(column, row) - view.source);
}

Ray ray_in(const volume::Frame& frame, const View& view, int column, int row) noexcept {
  return {frame.volume_from_world(view.source), frame.volume_from_world(view.pixel(column, row))};
}

}  // namespace

VolumeXray::VolumeXray(std::shared_ptr<const volume::Volume> scan, double energy_kev, int threads)
    : scan_(std::move(scan)), lines_(*scan_, weights_of_hounsfield(energy_kev), threads) {}

/// Returns the pixels with rays that may meet a block.
PixelBox VolumeXray::pixels_of_block(const View& view, const std::array<int, 3>& block) const {
  volume::VoxelBox box = RemovedMatter::box_of(block);
  // With interpolation, a ray between two voxels reads both.
  if (method_ == volume::RaySum::joseph) --box.low, ++box.high;
  double low_x = 1e300, low_y = 1e300, high_x = -1e300, high_y = -1e300;
  for (const dvec3& corner : volume::corners_world(scan_->frame, box.low, box.high)) {
    const auto at = view.project(corner);
    if (!at) return view.open;  // level with or behind the source: any pixel
    low_x = std::min(low_x, at->x), high_x = std::max(high_x, at->x);
    low_y = std::min(low_y, at->y), high_y = std::max(high_y, at->y);
  }
  const auto clamped = [](double v, int low, int high) {
    return static_cast<int>(std::clamp(v, static_cast<double>(low), static_cast<double>(high)));
  };
  const PixelBox& open = view.open;
  return {clamped(std::floor(low_x) - 1, open.column_low, open.column_high),
          clamped(std::floor(low_y) - 1, open.row_low, open.row_high),
          clamped(std::ceil(high_x) + 2, open.column_low, open.column_high),
          clamped(std::ceil(high_y) + 2, open.row_low, open.row_high)};
}

/// Traces the removed matter in the tiles of changed blocks; in all tiles if `changed` is null.
void VolumeXray::update_removed(const View& view, const std::vector<ivec3>* changed, int threads) {
  const int down = (view.rows + k_tile - 1) / k_tile;
  tiles_across_ = (view.columns + k_tile - 1) / k_tile;
  tiles_.assign(static_cast<std::size_t>(tiles_across_) * static_cast<std::size_t>(down), {});
  std::vector<std::uint8_t> is_stale(tiles_.size(), changed == nullptr);
  const auto for_tiles = [&](const PixelBox& box, auto&& use) {
    if (box.is_empty()) return;
    for (int row = box.row_low / k_tile; row <= (box.row_high - 1) / k_tile; ++row)
      for (int column = box.column_low / k_tile; column <= (box.column_high - 1) / k_tile; ++column)
        use(static_cast<std::size_t>(column) +
            static_cast<std::size_t>(tiles_across_) * static_cast<std::size_t>(row));
  };
  for (const auto& block : removed_.blocks())
    for_tiles(pixels_of_block(view, block.first), [&](std::size_t tile) { tiles_[tile].push_back(&block); });
  if (changed != nullptr)
    for (const ivec3& c : *changed)
      for_tiles(pixels_of_block(view, {c.z, c.y, c.x}), [&](std::size_t tile) { is_stale[tile] = 1; });
  std::vector<int> stale;
  for (std::size_t tile = 0; tile < tiles_.size(); ++tile)
    if (is_stale[tile]) stale.push_back(static_cast<int>(tile));
  std::atomic<std::int64_t> rays{0};
  const volume::RayFan fan = view.ray_fan_in(scan_->frame);
  parallel_for(static_cast<int>(stale.size()), threads, [&](int n) {
    const int tile = stale[static_cast<std::size_t>(n)];
    const BlockList& blocks = tiles_[static_cast<std::size_t>(tile)];
    const int column_low = std::max(view.open.column_low, tile % tiles_across_ * k_tile),
              row_low = std::max(view.open.row_low, tile / tiles_across_ * k_tile);
    const int column_high = std::min(view.open.column_high, (tile % tiles_across_ + 1) * k_tile),
              row_high = std::min(view.open.row_high, (tile / tiles_across_ + 1) * k_tile);
    for (int row = row_low; row < row_high; ++row)
      for (int column = column_low; column < column_high; ++column) {
        double sum = 0;
        if (!blocks.empty()) {
          const Ray ray = ray_in(scan_->frame, view, column, row);
          const int axis = method_ == volume::RaySum::joseph ? fan.slab_axis(column, row) : 0;
          for (const auto* block : blocks)
            sum += method_ == volume::RaySum::joseph
                       ? RemovedMatter::interpolated_sum(ray, axis, block->first, block->second)
                       : RemovedMatter::sum(ray, 0, 1, block->first, block->second);
          sum *= length_of(view, column, row);
          rays.fetch_add(1, std::memory_order_relaxed);
        }
        removed_sums_[index_of(view, column, row)] = sum;
      }
  });
  counters_.renewed_rays += rays;
}

double VolumeXray::operated_integral(const Ray& ray, double from, double to, std::size_t tile) const {
  double sum = lines_.integrate(ray, from, to);
  for (const auto* block : tiles_[tile])
    sum -= RemovedMatter::sum(ray, from, to, block->first, block->second);
  return sum;
}

/// Replaces the scan's attenuation inside the objects by that of the objects.
Status VolumeXray::add_objects(const View& view, std::span<const XrayObject> objects, int threads,
                               std::vector<double>& sums) {
  struct Hit {
    std::size_t pixel;
    double t;
    int into;
    std::size_t object;
  };
  std::vector<Hit> hits;
  for (std::size_t i = 0; i < objects.size(); ++i) {
    std::vector<dvec3> vertices;
    vertices.reserve(objects[i].tree->vertices().size());
    for (const dvec3& v : objects[i].tree->vertices())
      vertices.push_back(objects[i].placement.world_from_local(v));
    if (!for_crossings(view, {vertices, objects[i].tree->triangles()}, [&](const Crossing& c) {
          hits.push_back({index_of(view, c.column, c.row), c.t, c.into, i});
        }))
      return Error{.what = "an object reaches the C-arm's source",
                   .where = "objects",
                   .found = std::to_string(i + 1),
                   .expected = "all of the object in front of the source",
                   .remedy = "move the C-arm"};
  }
  std::sort(hits.begin(), hits.end(), [](const Hit& a, const Hit& b) {
    return a.pixel != b.pixel ? a.pixel < b.pixel : a.t != b.t ? a.t < b.t : a.object < b.object;
  });
  std::vector<std::size_t> first;
  for (std::size_t i = 0; i < hits.size(); ++i)
    if (i == 0 || hits[i].pixel != hits[i - 1].pixel) first.push_back(i);
  counters_.object_rays += static_cast<std::int64_t>(first.size());
  parallel_for(static_cast<int>(first.size()), threads, [&](int n) {
    const std::size_t begin = first[static_cast<std::size_t>(n)],
                      end = static_cast<std::size_t>(n) + 1 < first.size()
                                ? first[static_cast<std::size_t>(n) + 1]
                                : hits.size();
    const std::size_t pixel = hits[begin].pixel;
    const int column = static_cast<int>(pixel % static_cast<std::size_t>(view.columns)),
              row = static_cast<int>(pixel / static_cast<std::size_t>(view.columns));
    const Ray ray = ray_in(scan_->frame, view, column, row);
    const double length = length_of(view, column, row);
    std::vector<int> depth(objects.size(), 0);
    for (std::size_t i = begin; i + 1 < end; ++i) {
      depth[hits[i].object] += hits[i].into;
      if (!(hits[i].t < hits[i + 1].t)) continue;
      // Implants have priority over pieces of bone; among several, the first in `objects`.
      const XrayObject* inside = nullptr;
      for (std::size_t k = 0; k < objects.size(); ++k)
        if (depth[k] > 0 && (inside == nullptr || (inside->is_of_scan && !objects[k].is_of_scan)))
          inside = &objects[k];
      if (inside == nullptr) continue;
      double integral = inside->attenuation * (hits[i + 1].t - hits[i].t);
      if (inside->is_of_scan) {
        const haptics::Placement back = inside->placement.inverse();
        const volume::Frame& frame = scan_->frame;
        integral = lines_.integrate({frame.volume_from_world(back.world_from_local(view.source)),
                                     frame.volume_from_world(back.world_from_local(view.pixel(column, row)))},
                                    hits[i].t, hits[i + 1].t);
      }
      sums[pixel] +=
          length * (integral - operated_integral(ray, hits[i].t, hits[i + 1].t, tile_of(column, row)));
    }
  });
  return std::nullopt;
}

Status VolumeXray::project(const View& view, std::shared_ptr<const volume::Version> version,
                           std::span<const XrayObject> objects, volume::RaySum method, int threads) {
  counters_ = {};
  const bool is_new = !view_ || !is_same(*view_, view) || method_ != method;
  const std::vector<ivec3> changed = removed_.update(lines_, std::move(version), threads);
  const PixelBox& open = view.open;
  if (is_new) {
    view_ = view, method_ = method;
    const std::size_t count = static_cast<std::size_t>(view.columns) * static_cast<std::size_t>(view.rows);
    full_sums_.assign(count, 0), removed_sums_.assign(count, 0);
    lines_.integrate(view.ray_fan_in(scan_->frame), open, method, threads, full_sums_);
    for (int row = open.row_low; row < open.row_high; ++row)
      for (int column = open.column_low; column < open.column_high; ++column)
        full_sums_[index_of(view, column, row)] *= length_of(view, column, row);
    counters_.full_rays +=
        static_cast<std::int64_t>(open.column_high - open.column_low) * (open.row_high - open.row_low);
    update_removed(view, nullptr, threads);
  } else if (!changed.empty()) {
    update_removed(view, &changed, threads);
  }
  std::vector<double> sums(full_sums_.size());
  for (std::size_t i = 0; i < sums.size(); ++i) sums[i] = full_sums_[i] - removed_sums_[i];
  if (Status error = add_objects(view, objects, threads, sums)) return error;
  for (double& sum : sums) sum = std::max(sum, 0.0);  // rounding where all matter was removed
  sums_ = std::move(sums);
  return std::nullopt;
}

/// Returns the scan's axis nearest to the central ray.
int VolumeXray::beam_axis(const View& view) const {
  const Ray middle = ray_in(scan_->frame, view, view.columns / 2, view.rows / 2);
  const dvec3 along = glm::abs(middle.end - middle.start);
  return along.x > along.y ? (along.x > along.z ? 0 : 2) : (along.y > along.z ? 1 : 2);
}
/// Returns the scan's axis nearest to the direction from foot to head.
int VolumeXray::body_axis() const {
  int axis = 0;
  for (int a = 1; a < 3; ++a)
    if (std::abs(scan_->frame.axes()[a].z) / scan_->frame.spacing()[a] >
        std::abs(scan_->frame.axes()[axis].z) / scan_->frame.spacing()[axis])
      axis = a;
  return axis;
}

std::vector<double> VolumeXray::sums_outside(const View& view, int threads) const {
  constexpr int k_tissue = 40;     // HU, in place of bone
  constexpr int k_step = 4;        // pixels: values between them are interpolated ...
  constexpr double k_even = 0.03;  // ... if they differ by less, which is invisible
  std::vector<double> result(static_cast<std::size_t>(view.columns) * static_cast<std::size_t>(view.rows), 0);
  const dvec3 size(scan_->size);
  const int d = beam_axis(view), body = body_axis(), side = 3 - d - body;
  if (d == body) return result;
  const PixelBox& open = view.open;
  const auto at_pixel = [&](int column, int row) {
    const Ray ray = ray_in(scan_->frame, view, column, row);
    const dvec3 along = ray.end - ray.start;
    if (std::abs(along[d]) < 1e-6) return 0.0;
    double sum = 0;
    for (int k = 0; k < scan_->size[d]; ++k) {
      const double t = (k - ray.start[d]) / along[d], at_side = ray.start[side] + t * along[side];
      if (at_side >= -0.5 && at_side <= size[side] - 0.5) continue;  // within the scan
      const double at_body = ray.start[body] + t * along[body];
      if (!(t >= 0 && t <= 1) || at_body < -0.5 || at_body > size[body] - 0.5) continue;
      ivec3 v;
      v[d] = k, v[side] = at_side < 0 ? 0 : scan_->size[side] - 1;
      v[body] = std::clamp(static_cast<int>(at_body + 0.5), 0, scan_->size[body] - 1);
      const int intensity = scan_->voxels[scan_->index(v.x, v.y, v.z)];
      sum += lines_.weights().of(std::min(intensity, k_tissue));
    }
    return sum / std::abs(along[d]) * length_of(view, column, row);
  };
  const int across = (open.column_high - open.column_low + k_step - 1) / k_step + 1,
            down = (open.row_high - open.row_low + k_step - 1) / k_step + 1;
  std::vector<double> coarse(static_cast<std::size_t>(across) * static_cast<std::size_t>(down));
  const auto coarse_index = [across](int i, int j) {
    return static_cast<std::size_t>(i) + static_cast<std::size_t>(across) * static_cast<std::size_t>(j);
  };
  parallel_for(down, threads, [&](int j) {
    for (int i = 0; i < across; ++i)
      coarse[coarse_index(i, j)] = at_pixel(open.column_low + k_step * i, open.row_low + k_step * j);
  });
  parallel_for(open.row_high - open.row_low, threads, [&](int row) {
    const int j = row / k_step;
    const double v = static_cast<double>(row % k_step) / k_step;
    for (int column = 0; column < open.column_high - open.column_low; ++column) {
      const int i = column / k_step;
      const double u = static_cast<double>(column % k_step) / k_step;
      const double a = coarse[coarse_index(i, j)], b = coarse[coarse_index(i + 1, j)],
                   c = coarse[coarse_index(i, j + 1)], e = coarse[coarse_index(i + 1, j + 1)];
      const auto [lowest, highest] = std::minmax({a, b, c, e});
      result[index_of(view, open.column_low + column, open.row_low + row)] =
          highest - lowest > k_even ? at_pixel(open.column_low + column, open.row_low + row)
                                    : (1 - v) * ((1 - u) * a + u * b) + v * ((1 - u) * c + u * e);
    }
  });
  return result;
}

/// Returns true if more than a thousandth of the voxels of a slice across an axis are tissue: the slice cuts
/// the body. Noise and the edge of the scanner's table are assumed to fill less.
bool VolumeXray::has_tissue_in_slice(int axis, int index) const {
  const int a = axis == 0 ? 1 : 0, b = axis == 2 ? 1 : 2;
  std::int64_t tissue = 0;
  ivec3 v;
  v[axis] = index;
  for (v[b] = 0; v[b] < scan_->size[b]; ++v[b])
    for (v[a] = 0; v[a] < scan_->size[a]; ++v[a])
      tissue += scan_->voxels[scan_->index(v.x, v.y, v.z)] >= k_tissue_from;
  return 1000 * tissue > std::int64_t{scan_->size[a]} * scan_->size[b];
}

std::vector<Border> VolumeXray::borders(const View& view) const {
  std::vector<Border> result(static_cast<std::size_t>(view.columns) * static_cast<std::size_t>(view.rows),
                             Border::none);
  const ivec3 size = scan_->size;
  const int beam = beam_axis(view), body = body_axis();
  // A ray must stay between these slices over the scan's thickness along the beam, otherwise its border is
  // `end`.
  constexpr double k_anywhere = std::numeric_limits<double>::infinity();
  const double lowest = beam != body && has_tissue_in_slice(body, 0) ? -0.5 : -k_anywhere,
               highest =
                   beam != body && has_tissue_in_slice(body, size[body] - 1) ? size[body] - 0.5 : k_anywhere;
  parallel_for(view.open.row_high - view.open.row_low, 0, [&](int n) {
    const int row = view.open.row_low + n;
    for (int column = view.open.column_low; column < view.open.column_high; ++column) {
      const Ray ray = ray_in(scan_->frame, view, column, row);
      const dvec3 along = ray.end - ray.start;
      Border& border = result[index_of(view, column, row)];
      double t_enter = 0, t_exit = 1;
      for (int a = 0; a < 3; ++a) {
        if (along[a] == 0) {
          if (ray.start[a] < -0.5 || ray.start[a] >= size[a] - 0.5) t_exit = -1;
          continue;
        }
        const double low = (-0.5 - ray.start[a]) / along[a], high = (size[a] - 0.5 - ray.start[a]) / along[a];
        if (a == beam)
          for (const double t : {low, high}) {
            const double at = ray.start[body] + std::clamp(t, 0.0, 1.0) * along[body];
            if (at < lowest || at > highest) border = Border::end;
          }
        t_enter = std::max(t_enter, std::min(low, high)), t_exit = std::min(t_exit, std::max(low, high));
      }
      if (border == Border::end || !(t_enter < t_exit)) continue;
      for (const double t : {t_enter, t_exit}) {
        if (t <= 0 || t >= 1) continue;  // source or detector within the scan
        const ivec3 v = glm::clamp(volume::voxel_of(ray.start + t * along), ivec3(0), size - 1);
        if (scan_->voxels[scan_->index(v.x, v.y, v.z)] >= k_tissue_from) border = Border::side;
      }
    }
  });
  return result;
}

}  // namespace trephine::fluoroscopy
