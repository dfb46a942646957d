#include "apps/bench/voxel_images.h"

#include <algorithm>
#include <bit>
#include <glm/common.hpp>

#include "haptics/depth/depth_cube.h"

namespace trephine::bench {

using glm::ivec3;
using haptics::depth::across;
using volume::SurfaceSource;
using volume::VoxelSamples;

namespace {

/// Reads a row along x: one bit per voxel, set for solid voxels that remain after the cuts.
void solid_row(const SurfaceSource& source, int y, int z, std::vector<std::uint64_t>& words) {
  const int count = source.bits->words_per_row();
  words.assign(source.bits->row(y, z), source.bits->row(y, z) + count);
  if (source.version != nullptr && source.version->has_brick(y, z, 0, count))
    source.version->mask_row(y, z, 0, count, words.data());
}

}  // namespace

VoxelImages::VoxelImages(const SurfaceSource& source) : size_(source.bits->size()) {
  for (int axis = 0; axis < 3; ++axis)
    for (const bool from_high : {false, true}) {
      const auto [u, v] = across(axis);
      images_[static_cast<std::size_t>(2 * axis + from_high)].resize(static_cast<std::size_t>(size_[u]) *
                                                                     static_cast<std::size_t>(size_[v]));
    }
  for (const bool from_high : {false, true}) {
    scan_rows(source, from_high);
    scan_across(source, 1, from_high);
    scan_across(source, 2, from_high);
  }
}

void VoxelImages::set_pixel(const VoxelSamples& samples, int axis, bool from_high, const ivec3& first,
                            Pixel& to) {
  ivec3 before = first;
  before[axis] += from_high ? 1 : -1;
  // A solid that reaches the border of the volume ends half a voxel beyond the centre of its last voxel.
  const bool is_within = before[axis] >= 0 && before[axis] < size_[axis];
  const float far = is_within ? samples.crossing(first, before) : 0.5f;
  to.voxel = first[axis];
  to.at = static_cast<float>(first[axis]) + (from_high ? far : -far);
}

void VoxelImages::scan_rows(const SurfaceSource& source, bool from_high) {
  const VoxelSamples samples(source);
  Image& image = images_[from_high];
  std::vector<std::uint64_t> words;
  for (int z = 0; z < size_.z; ++z)
    for (int y = 0; y < size_.y; ++y) {
      solid_row(source, y, z, words);
      const int count = static_cast<int>(words.size());
      for (int k = 0; k < count; ++k) {
        const int w = from_high ? count - 1 - k : k;
        const std::uint64_t word = words[static_cast<std::size_t>(w)];
        if (word == 0) continue;
        const int x = 64 * w + (from_high ? 63 - std::countl_zero(word) : std::countr_zero(word));
        set_pixel(samples, 0, from_high, {x, y, z}, image[pixel(0, y, z)]);
        break;
      }
    }
}

/// Scans the 64 rows of a word at a time. `open` marks the rows in which no solid voxel has been found.
void VoxelImages::scan_across(const SurfaceSource& source, int axis, bool from_high) {
  const VoxelSamples samples(source);
  Image& image = images_[static_cast<std::size_t>(2 * axis + from_high)];
  const int other = 3 - axis, count = source.bits->words_per_row();
  std::vector<std::uint64_t> words, open(static_cast<std::size_t>(count));
  for (int j = 0; j < size_[other]; ++j) {
    std::fill(open.begin(), open.end(), ~std::uint64_t{0});
    for (int k = 0; k < size_[axis]; ++k) {
      ivec3 at(0);
      at[axis] = from_high ? size_[axis] - 1 - k : k, at[other] = j;
      solid_row(source, at.y, at.z, words);
      for (std::size_t w = 0; w < words.size(); ++w) {
        std::uint64_t hits = words[w] & open[w];
        open[w] &= ~hits;
        for (; hits != 0; hits &= hits - 1) {
          at.x = 64 * static_cast<int>(w) + std::countr_zero(hits);
          set_pixel(samples, axis, from_high, at, image[pixel(axis, at.x, j)]);
        }
      }
    }
  }
}

void VoxelImages::update(const SurfaceSource& source, const volume::VoxelBox& changed) {
  query_count_ = 0;
  const VoxelSamples samples(source);
  // A changed voxel also moves the surface in the neighbouring voxels.
  const ivec3 low = glm::max(changed.low - 1, ivec3(0)), high = glm::min(changed.high + 1, size_ - 1);
  if (low.x > high.x || low.y > high.y || low.z > high.z) return;
  for (int axis = 0; axis < 3; ++axis) {
    const auto [u, v] = across(axis);
    for (const bool from_high : {false, true}) {
      Image& image = images_[static_cast<std::size_t>(2 * axis + from_high)];
      const int step = from_high ? -1 : 1, enter = from_high ? high[axis] : low[axis],
                leave = from_high ? low[axis] : high[axis], end = from_high ? -1 : size_[axis];
      for (int j = low[v]; j <= high[v]; ++j)
        for (int i = low[u]; i <= high[u]; ++i) {
          Pixel& known = image[pixel(axis, i, j)];
          if (known.voxel >= 0 && step * known.voxel < step * enter)
            continue;  // the row meets a solid voxel before the box
          ivec3 at(0);
          at[u] = i, at[v] = j;
          const auto find = [&](int from, int to) {  // excludes `to`
            for (int k = from; k != to; k += step) {
              at[axis] = k;
              ++query_count_;
              if (samples.is_solid(at)) return true;
            }
            return false;
          };
          const bool was_beyond = known.voxel < 0 || step * known.voxel > step * leave;
          if (find(enter, leave + step)) {
            set_pixel(samples, axis, from_high, at, known);
          } else if (!was_beyond) {
            // The voxel of this pixel was removed, and the row is free within the box.
            if (find(leave + step, end))
              set_pixel(samples, axis, from_high, at, known);
            else
              known = {};
          }
        }
    }
  }
}

}  // namespace trephine::bench
