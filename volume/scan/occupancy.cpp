#include "volume/scan/occupancy.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <emmintrin.h>
#include <limits>

#include "volume/base/parallel.h"
#include "volume/base/work_counters.h"

namespace trephine::volume {

namespace {

constexpr int k_farthest = 64;  // blocks; longer empty boxes give no further speed

/// Range of the integers inside a window of intensities; may be empty.
struct IntWindow {
  int low, high;
  explicit IntWindow(const Shape& shape) {
    constexpr double k_min = std::numeric_limits<std::int16_t>::min(),
                     k_max = std::numeric_limits<std::int16_t>::max();
    low = static_cast<int>(std::clamp(std::ceil(shape.low), k_min, k_max + 1));
    high = static_cast<int>(std::clamp(std::floor(shape.high), k_min - 1, k_max));
  }
};

/// Returns 64 bits for 64 intensities (SSE2, part of every x86-64). Requires a window with an int16 inside.
std::uint64_t threshold_64(const std::int16_t* voxel, __m128i low, __m128i high) {
  std::uint64_t bits = 0;
  for (int i = 0; i < 4; ++i) {
    const auto* at = reinterpret_cast<const __m128i*>(voxel + 16 * i);
    const __m128i a = _mm_loadu_si128(at), b = _mm_loadu_si128(at + 1);
    const __m128i out_a = _mm_or_si128(_mm_cmplt_epi16(a, low), _mm_cmpgt_epi16(a, high));
    const __m128i out_b = _mm_or_si128(_mm_cmplt_epi16(b, low), _mm_cmpgt_epi16(b, high));
    const auto out = static_cast<unsigned>(_mm_movemask_epi8(_mm_packs_epi16(out_a, out_b)));
    bits |= static_cast<std::uint64_t>(~out & 0xffffu) << (16 * i);
  }
  return bits;
}

}  // namespace

void threshold_row(const Volume& volume, const Shape& shape, int y, int z, std::uint64_t* words) {
  const std::size_t start = volume.index(0, y, z);
  const int count = volume.size.x;
  if (shape.is_label()) {
    for (int x = 0; x < count; x += 64) {
      std::uint64_t bits = 0;
      for (int i = 0; i < std::min(64, count - x); ++i)
        bits |=
            static_cast<std::uint64_t>(volume.labels[start + static_cast<std::size_t>(x + i)] == shape.label)
            << i;
      words[x / 64] = bits;
    }
    return;
  }
  const IntWindow window(shape);
  if (window.low > window.high) {
    std::fill(words, words + (count + 63) / 64, 0);
    return;
  }
  const __m128i low = _mm_set1_epi16(static_cast<short>(window.low));
  const __m128i high = _mm_set1_epi16(static_cast<short>(window.high));
  const std::int16_t* row = volume.window_voxels().data() + start;
  int x = 0;
  for (; x + 64 <= count; x += 64) words[x / 64] = threshold_64(row + x, low, high);
  if (x < count) {
    std::int16_t rest[64] = {};
    std::memcpy(rest, row + x, static_cast<std::size_t>(count - x) * sizeof(std::int16_t));
    words[x / 64] = threshold_64(rest, low, high) & ((1ull << (count - x)) - 1);
  }
}

Occupancy Occupancy::build(const Volume& volume, const Shape& shape, int threads) {
  ++work_counters().occupancies;
  Occupancy result;
  result.size_ = volume.size;
  result.blocks_ = (volume.size + 3) / 4;
  result.words_per_row_ = (volume.size.x + 63) / 64;
  result.words_ = Buffer<std::uint64_t>(static_cast<std::size_t>(result.words_per_row_) *
                                        static_cast<std::size_t>(volume.size.y) *
                                        static_cast<std::size_t>(volume.size.z));
  parallel_for(volume.size.z, threads, [&](int z) {
    for (int y = 0; y < volume.size.y; ++y)
      threshold_row(volume, shape, y, z, result.words_.data() + result.word_index(y, z));
  });
  result.build_distance(threads);
  return result;
}

void Occupancy::build_distance(int threads) {
  const auto nx = static_cast<std::size_t>(blocks_.x), ny = static_cast<std::size_t>(blocks_.y),
             nz = static_cast<std::size_t>(blocks_.z);
  distance_ = Buffer<std::uint8_t>(nx * ny * nz);
  const auto line = [&](int y, int z) {
    return distance_.data() + nx * (static_cast<std::size_t>(y) + ny * static_cast<std::size_t>(z));
  };

  // Sets blocks with a solid voxel to 0: ORs the sixteen rows of a line of blocks, then tests groups of four.
  parallel_for(blocks_.z, threads, [&](int bz) {
    for (int by = 0; by < blocks_.y; ++by) {
      std::uint8_t* out = line(by, bz);
      for (int w = 0; w < words_per_row_; ++w) {
        std::uint64_t any = 0;
        for (int z = 4 * bz; z < std::min(4 * bz + 4, size_.z); ++z)
          for (int y = 4 * by; y < std::min(4 * by + 4, size_.y); ++y) any |= row(y, z)[w];
        for (int i = 0; i < std::min(16, blocks_.x - 16 * w); ++i)
          out[16 * w + i] = (any >> (4 * i) & 0xf) ? 0 : k_farthest;
      }
    }
  });

  // Two raster passes over the 13 neighbours already processed give the exact chessboard distance
  // (Rosenfeld and Pfaltz 1968): first whole lines, which the compiler vectorizes, then along x.
  const auto relax = [nx](std::uint8_t* to, const std::uint8_t* from) {
    for (std::size_t x = 0; x < nx; ++x) {
      std::uint8_t near = from[x];
      if (x > 0) near = std::min(near, from[x - 1]);
      if (x + 1 < nx) near = std::min(near, from[x + 1]);
      to[x] = std::min(to[x], static_cast<std::uint8_t>(near + 1));
    }
  };
  const auto pass = [&](int y, int z, int back) {
    for (int dy = -1; dy <= 1; ++dy)
      if (z + back >= 0 && z + back < blocks_.z && y + dy >= 0 && y + dy < blocks_.y)
        relax(line(y, z), line(y + dy, z + back));
    if (y + back >= 0 && y + back < blocks_.y) relax(line(y, z), line(y + back, z));
  };
  for (int z = 0; z < blocks_.z; ++z)
    for (int y = 0; y < blocks_.y; ++y) {
      pass(y, z, -1);
      std::uint8_t* d = line(y, z);
      for (std::size_t x = 1; x < nx; ++x) d[x] = std::min(d[x], static_cast<std::uint8_t>(d[x - 1] + 1));
    }
  for (int z = blocks_.z - 1; z >= 0; --z)
    for (int y = blocks_.y - 1; y >= 0; --y) {
      pass(y, z, +1);
      std::uint8_t* d = line(y, z);
      for (std::size_t x = nx - 1; x-- > 0;) d[x] = std::min(d[x], static_cast<std::uint8_t>(d[x + 1] + 1));
    }
}

std::size_t Occupancy::count_solid() const noexcept {
  std::size_t count = 0;
  for (const std::uint64_t word : words_.span()) count += static_cast<std::size_t>(std::popcount(word));
  return count;
}

}  // namespace trephine::volume
