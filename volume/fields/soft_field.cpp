#include "volume/fields/soft_field.h"

#include <bit>
#include <cmath>

#include "volume/base/deterministic_math.h"
#include "volume/base/parallel.h"

namespace trephine::volume {

using glm::ivec3;

namespace {

constexpr int k_edge = SampleBrick::k_edge, k_reach = SoftField::k_reach;
constexpr int k_guard = 2;                   // voxels around a sample in which the blur is tested
constexpr int k_mid = k_edge + 2 * k_guard;  // blurred samples along an edge
constexpr int k_wide = k_mid + 2 * k_reach;  // bits read by the blur along an edge

/// Bits x0 .. x0 + count - 1 (count <= 32) of row (y, z); air outside the grid.
std::uint32_t bits_of_row(const Occupancy& bits, int x0, int y, int z, int count) noexcept {
  const ivec3& size = bits.size();
  if (y < 0 || z < 0 || y >= size.y || z >= size.z) return 0;
  const std::uint64_t* row = bits.row(y, z);
  const int words = bits.words_per_row();
  const auto word = [&](int w) { return w >= 0 && w < words ? row[w] : 0; };
  const int w = x0 >> 6, shift = x0 & 63;
  std::uint64_t out = word(w) >> shift;
  if (shift > 0) out |= word(w + 1) << (64 - shift);
  return static_cast<std::uint32_t>(out & ((std::uint64_t{1} << count) - 1));
}

std::array<float, 2 * k_reach + 1> kernel() {
  std::array<double, 2 * k_reach + 1> exact{};
  double sum = 0;
  for (int k = -k_reach; k <= k_reach; ++k)
    sum += exact[static_cast<std::size_t>(k + k_reach)] =
        deterministic_exp(-0.5 * k * k / (SoftField::k_sigma * SoftField::k_sigma));
  std::array<float, 2 * k_reach + 1> weights{};
  for (std::size_t k = 0; k < weights.size(); ++k) weights[k] = static_cast<float>(exact[k] / sum);
  return weights;
}

/// Working memory of one thread.
struct Scratch {
  std::array<std::uint32_t, static_cast<std::size_t>(k_wide) * k_wide> rows;  ///< [z][y], bits along x
  std::array<float, static_cast<std::size_t>(k_wide) * k_wide * k_mid> blurred_x;
  std::array<float, static_cast<std::size_t>(k_wide) * k_mid * k_mid> blurred_xy;
  std::array<float, static_cast<std::size_t>(k_mid) * k_mid * k_mid> blurred;
};

constexpr int k_overlap = SoftField::k_overlap;
constexpr int k_far = k_wide + 2 * k_overlap;  // bits that may extend into the wide window, along an edge
constexpr int k_far_padded = k_far + 2;        // these and one voxel around them
static_assert(k_far_padded <= 32);
using FarRows = std::array<std::uint32_t, static_cast<std::size_t>(k_far) * k_far>;  ///< [z][y], bits along x
std::size_t wide_row(int y, int z) noexcept { return static_cast<std::size_t>(y + k_wide * z); }
std::size_t far_row(int y, int z) noexcept { return static_cast<std::size_t>(y + k_far * z); }

/// Adds to the window at `first` the voxels of the hosts within a chessboard distance of k_overlap from
/// `sources`.
void extend(const FarRows& sources, std::span<const Occupancy* const> hosts, const ivec3& first, Scratch& s) {
  // Dilates along x, then y, then z.
  FarRows along_x;
  for (std::size_t i = 0; i < sources.size(); ++i) {
    std::uint32_t dilated = 0;
    for (int k = 0; k <= 2 * k_overlap; ++k) dilated |= sources[i] >> k;
    along_x[i] = dilated & ((1u << k_wide) - 1);
  }
  std::array<std::uint32_t, static_cast<std::size_t>(k_wide) * k_far> along_y{};
  for (int z = 0; z < k_far; ++z)
    for (int y = 0; y < k_wide; ++y)
      for (int k = 0; k <= 2 * k_overlap; ++k) along_y[wide_row(y, z)] |= along_x[far_row(y + k, z)];
  for (int z = 0; z < k_wide; ++z)
    for (int y = 0; y < k_wide; ++y) {
      std::uint32_t dilated = 0, host_bits = 0;
      for (int k = 0; k <= 2 * k_overlap; ++k) dilated |= along_y[wide_row(y, z + k)];
      for (const Occupancy* host : hosts)
        host_bits |= bits_of_row(*host, first.x, first.y + y, first.z + z, k_wide);
      s.rows[wide_row(y, z)] |= dilated & host_bits;
    }
}

/// Returns the voxels of the shape that have a neighbour in air: neither in the shape nor in `neighbours`.
FarRows find_exposed(const Occupancy& bits, const SoftNeighbours& neighbours, const ivec3& first) {
  std::array<std::uint32_t, static_cast<std::size_t>(k_far_padded) * k_far_padded> air;
  const auto row = [](int y, int z) { return static_cast<std::size_t>(y + k_far_padded * z); };
  const ivec3 corner = first - (k_overlap + 1);
  for (int z = 0; z < k_far_padded; ++z)
    for (int y = 0; y < k_far_padded; ++y) {
      std::uint32_t solid = bits_of_row(bits, corner.x, corner.y + y, corner.z + z, k_far_padded);
      for (const auto& hosts : {neighbours.whole, neighbours.at_surface})
        for (const Occupancy* host : hosts)
          solid |= bits_of_row(*host, corner.x, corner.y + y, corner.z + z, k_far_padded);
      // Bit x: there is air at x, x + 1 or x + 2.
      air[row(y, z)] = ~solid | ~solid >> 1 | ~solid >> 2;
    }
  FarRows sources;
  for (int z = 0; z < k_far; ++z)
    for (int y = 0; y < k_far; ++y) {
      std::uint32_t near = 0;
      for (int dz = 0; dz < 3; ++dz)
        for (int dy = 0; dy < 3; ++dy) near |= air[row(y + dy, z + dz)];
      sources[far_row(y, z)] =
          near & bits_of_row(bits, corner.x + 1, corner.y + 1 + y, corner.z + 1 + z, k_far);
    }
  return sources;
}

/// Collects the bits of the wide window at `first`: those of the shape, extended into its neighbours.
void gather(const Occupancy& bits, const SoftNeighbours& neighbours, const ivec3& first, Scratch& s) {
  for (int z = 0; z < k_wide; ++z)
    for (int y = 0; y < k_wide; ++y)
      s.rows[wide_row(y, z)] = bits_of_row(bits, first.x, first.y + y, first.z + z, k_wide);
  if (!neighbours.whole.empty()) {
    FarRows sources;
    for (int z = 0; z < k_far; ++z)
      for (int y = 0; y < k_far; ++y)
        sources[far_row(y, z)] =
            bits_of_row(bits, first.x - k_overlap, first.y + y - k_overlap, first.z + z - k_overlap, k_far);
    extend(sources, neighbours.whole, first, s);
  }
  if (!neighbours.at_surface.empty())
    extend(find_exposed(bits, neighbours, first), neighbours.at_surface, first, s);
}

/// Number of solid voxels of the window in the brick and its guard.
int count_near(const Scratch& s) {
  int count = 0;
  for (int z = k_reach; z < k_reach + k_mid; ++z)
    for (int y = k_reach; y < k_reach + k_mid; ++y)
      count +=
          std::popcount(s.rows[static_cast<std::size_t>(y + k_wide * z)] >> k_reach & ((1u << k_mid) - 1));
  return count;
}

/// Computes the samples of the brick in the window.
void fill(const std::array<float, 2 * k_reach + 1>& weights, Scratch& s, SampleBrick& brick) {
  const auto at3 = [](int x, int y, int z, int ny) {
    return static_cast<std::size_t>(x + k_mid * (y + ny * z));
  };
  const auto solid = [&s](int x, int y, int z) {  // in the wide window
    return (s.rows[static_cast<std::size_t>(y + k_wide * z)] >> x & 1u) != 0;
  };
  constexpr int k_taps = 2 * k_reach + 1;
  // Table of the kernel's sum for each of the 512 patterns of taps, for one look-up per sample along x.
  std::array<float, 1 << k_taps> sums;
  for (std::size_t pattern = 0; pattern < sums.size(); ++pattern) {
    float sum = 0;
    for (int k = 0; k < k_taps; ++k)
      if (pattern >> k & 1u) sum += weights[static_cast<std::size_t>(k)];
    sums[pattern] = sum;
  }
  for (int z = 0; z < k_wide; ++z)
    for (int y = 0; y < k_wide; ++y)
      for (int x = 0; x < k_mid; ++x)
        s.blurred_x[at3(x, y, z, k_wide)] =
            sums[s.rows[static_cast<std::size_t>(y + k_wide * z)] >> x & ((1u << k_taps) - 1)];
  for (int z = 0; z < k_wide; ++z)
    for (int y = 0; y < k_mid; ++y)
      for (int x = 0; x < k_mid; ++x) {
        float sum = 0;
        for (int k = 0; k < k_taps; ++k)
          sum += weights[static_cast<std::size_t>(k)] * s.blurred_x[at3(x, y + k, z, k_wide)];
        s.blurred_xy[at3(x, y, z, k_mid)] = sum;
      }
  for (int z = 0; z < k_mid; ++z)
    for (int y = 0; y < k_mid; ++y)
      for (int x = 0; x < k_mid; ++x) {
        float sum = -0.5f;
        for (int k = 0; k < k_taps; ++k)
          sum += weights[static_cast<std::size_t>(k)] * s.blurred_xy[at3(x, y, z + k, k_mid)];
        s.blurred[at3(x, y, z, k_mid)] = sum;
      }
  for (int z = 0; z < k_edge; ++z)
    for (int y = 0; y < k_edge; ++y)
      for (int x = 0; x < k_edge; ++x) {
        bool is_thin = false;
        for (int dz = -k_guard; dz <= k_guard && !is_thin; ++dz)
          for (int dy = -k_guard; dy <= k_guard && !is_thin; ++dy)
            for (int dx = -k_guard; dx <= k_guard && !is_thin; ++dx) {
              const int mx = x + k_guard + dx, my = y + k_guard + dy, mz = z + k_guard + dz;
              const float g = s.blurred[at3(mx, my, mz, k_mid)];
              const bool is_solid = solid(mx + k_reach, my + k_reach, mz + k_reach);
              is_thin = (is_solid ? -g : g) > static_cast<float>(SoftField::k_conflict);
            }
        const bool is_solid = solid(x + k_guard + k_reach, y + k_guard + k_reach, z + k_guard + k_reach);
        const float g = s.blurred[at3(x + k_guard, y + k_guard, z + k_guard, k_mid)];
        constexpr float k_min = static_cast<float>(SoftField::k_min);
        brick.values[SampleBrick::index(x, y, z)] = is_thin    ? (is_solid ? 0.5f : -0.5f)
                                                    : is_solid ? std::max(g, k_min)
                                                               : std::min(g, -k_min);
      }
}

}  // namespace

std::shared_ptr<const SoftField> SoftField::build(const Occupancy& bits, int threads,
                                                  const SoftNeighbours& neighbours) {
  auto result = std::make_shared<SoftField>();
  result->size_ = bits.size();
  result->is_extended_ = !neighbours.is_empty();
  result->slots_size_ = (bits.size() + k_edge - 1) / k_edge;
  const ivec3 n = result->slots_size_;
  result->slots_.resize(static_cast<std::size_t>(n.x) * static_cast<std::size_t>(n.y) *
                        static_cast<std::size_t>(n.z));
  const auto weights = kernel();
  parallel_for(n.z, threads, [&](int bz) {
    auto scratch = std::make_unique<Scratch>();
    for (int by = 0; by < n.y; ++by)
      for (int bx = 0; bx < n.x; ++bx) {
        const ivec3 corner = k_edge * ivec3(bx, by, bz);
        SampleSlot& slot = result->slots_[result->slot_index(bx, by, bz)];
        // Skips bricks that are uniform within the guard and the possible extension.
        const int margin = k_guard + (neighbours.is_empty() ? 0 : k_overlap), wide = k_edge + 2 * margin;
        int count = 0;
        for (int z = -margin; z < k_edge + margin; ++z)
          for (int y = -margin; y < k_edge + margin; ++y)
            count += std::popcount(bits_of_row(bits, corner.x - margin, corner.y + y, corner.z + z, wide));
        slot.is_solid = count > 0;
        if (count == 0 || count == wide * wide * wide) continue;
        gather(bits, neighbours, corner - (k_guard + k_reach), *scratch);
        if (!neighbours.is_empty()) {
          const int near = count_near(*scratch);
          slot.is_solid = near > 0;
          if (near == 0 || near == k_mid * k_mid * k_mid) continue;
        }
        auto brick = std::make_shared<SampleBrick>();
        fill(weights, *scratch, *brick);
        slot.brick = std::move(brick);
      }
  });
  return result;
}

bool SoftField::is_two_valued(const Field& field, const Occupancy& bits) {
  if (field.shape().is_label()) return true;
  const Volume& volume = field.volume();
  const ivec3& size = volume.size;
  const Buffer<std::int16_t>& voxels = volume.window_voxels();
  // Along rows, the intensities on both sides of every transition must be the same pair.
  bool has_solid = false, has_air = false;
  std::int16_t solid = 0, air = 0;
  for (int z = 0; z < size.z; ++z)
    for (int y = 0; y < size.y; ++y)
      for (int x = 1; x < size.x; ++x) {
        const bool is_solid = bits.is_solid({x, y, z});
        if (is_solid == bits.is_solid({x - 1, y, z})) continue;
        const std::int16_t value = voxels[volume.index(x, y, z)],
                           previous = voxels[volume.index(x - 1, y, z)];
        const std::int16_t solid_value = is_solid ? value : previous, air_value = is_solid ? previous : value;
        if ((has_solid && solid_value != solid) || (has_air && air_value != air)) return false;
        // A grey ramp across x can have the same pair in every row. Therefore the next voxel on each side, if
        // it is on the same side of the surface, must have the same intensity.
        if (x + 1 < size.x && bits.is_solid({x + 1, y, z}) == is_solid &&
            voxels[volume.index(x + 1, y, z)] != value)
          return false;
        if (x >= 2 && bits.is_solid({x - 2, y, z}) != is_solid &&
            voxels[volume.index(x - 2, y, z)] != previous)
          return false;
        solid = solid_value, air = air_value;
        has_solid = has_air = true;
      }
  return has_solid;
}

double SoftField::at(int x, int y, int z) const noexcept {
  if (x < 0 || y < 0 || z < 0 || x >= size_.x || y >= size_.y || z >= size_.z) {
    const ivec3 v = glm::clamp(ivec3(x, y, z), ivec3(0), size_ - 1);
    return beyond_border(at(v.x, v.y, v.z));
  }
  const SampleSlot& slot = slots_[slot_index(x >> 3, y >> 3, z >> 3)];
  if (!slot.brick) return slot.is_solid ? 0.5 : -0.5;
  return static_cast<double>(slot.brick->values[SampleBrick::index_of({x, y, z})]);
}

bool SoftField::is_air_around(const ivec3& v) const noexcept {
  const ivec3 low = glm::max(v - 1, ivec3(0)), high = glm::min(v + 1, size_ - 1);
  for (int bz = low.z >> 3; bz <= high.z >> 3; ++bz)
    for (int by = low.y >> 3; by <= high.y >> 3; ++by)
      for (int bx = low.x >> 3; bx <= high.x >> 3; ++bx) {
        const SampleSlot& slot = slots_[slot_index(bx, by, bz)];
        if (!slot.brick) {
          if (slot.is_solid) return false;
          continue;
        }
        const ivec3 corner = 8 * ivec3(bx, by, bz), a = glm::max(low, corner), b = glm::min(high, corner + 7);
        for (int z = a.z; z <= b.z; ++z)
          for (int y = a.y; y <= b.y; ++y)
            for (int x = a.x; x <= b.x; ++x)
              if (slot.brick->values[SampleBrick::index_of({x, y, z})] >= 0) return false;
      }
  return true;
}

void SoftField::load(const ivec3& v, QuadraticPatch& patch) const noexcept {
  // A brick at the upper border extends beyond the grid, where its samples must not be used.
  const bool is_in_grid =
      v.x >= 0 && v.y >= 0 && v.z >= 0 && v.x + 1 < size_.x && v.y + 1 < size_.y && v.z + 1 < size_.z;
  const SampleBrick* brick =
      is_in_grid ? slots_[slot_index(v.x >> 3, v.y >> 3, v.z >> 3)].brick.get() : nullptr;
  load_around(v, brick, patch, [this](int x, int y, int z) { return at(x, y, z); });
}

std::size_t SoftField::bytes() const noexcept {
  std::size_t bricks = 0;
  for (const SampleSlot& slot : slots_) bricks += slot.brick != nullptr;
  return bricks * sizeof(SampleBrick) + slots_.size() * sizeof(SampleSlot);
}

}  // namespace trephine::volume
