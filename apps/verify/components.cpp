#include "apps/verify/components.h"

#include <algorithm>
#include <bit>

#include "volume/base/parallel.h"

namespace trephine::verify {

namespace {
/// Slices that a thread processes at a time.
constexpr int k_slab = 16;
int slabs_of(int slices) { return (slices + k_slab - 1) / k_slab; }
}  // namespace

Components::Components(const volume::Occupancy& bits, Connectivity touch, int threads)
    : size_(bits.size()), words_(static_cast<std::size_t>(bits.words_per_row())) {
  find_runs(threads, [&](int y, int z, std::uint64_t*) { return bits.row(y, z); });
  join_runs(touch, threads);
  number_parts();
}

Components::Components(const volume::Volume& scan, const volume::Shape& shape, Connectivity touch,
                       int threads)
    : size_(scan.size), words_(static_cast<std::size_t>((scan.size.x + 63) / 64)) {
  find_runs(threads, [&](int y, int z, std::uint64_t* scratch) {
    volume::threshold_row(scan, shape, y, z, scratch);
    return scratch;
  });
  join_runs(touch, threads);
  number_parts();
}

template <class RowBits>
void Components::find_runs(int threads, const RowBits& row_bits) {
  const std::size_t rows = row_of(0, size_.z);
  first_.assign(rows + 1, 0);
  // Find the runs of each slab separately, then concatenate them.
  std::vector<std::vector<Run>> slab_runs(static_cast<std::size_t>(slabs_of(size_.z)));
  parallel_for(slabs_of(size_.z), threads, [&](int slab) {
    std::vector<Run>& runs = slab_runs[static_cast<std::size_t>(slab)];
    std::vector<std::uint64_t> scratch(words_);
    for (int z = k_slab * slab; z < std::min(k_slab * (slab + 1), size_.z); ++z)
      for (int y = 0; y < size_.y; ++y) {
        const std::size_t before = runs.size();
        add_runs(row_bits(y, z, scratch.data()), runs);
        first_[row_of(y, z) + 1] = static_cast<std::uint32_t>(runs.size() - before);
      }
  });
  for (std::size_t row = 0; row < rows; ++row) first_[row + 1] += first_[row];
  runs_.resize(first_[rows]);
  parallel_for(slabs_of(size_.z), threads, [&](int slab) {
    std::vector<Run>& runs = slab_runs[static_cast<std::size_t>(slab)];
    std::copy(runs.begin(), runs.end(), runs_.begin() + first_[row_of(0, k_slab * slab)]);
    runs = {};
  });
}

void Components::add_runs(const std::uint64_t* words, std::vector<Run>& runs) const {
  bool is_continued = false;
  for (std::size_t w = 0; w < words_; ++w) {
    const int base = 64 * static_cast<int>(w);
    std::uint64_t remaining = words[w];
    if (is_continued && (remaining & 1) == 0) is_continued = false;
    while (remaining != 0) {
      const int from = std::countr_zero(remaining), length = std::countr_one(remaining >> from);
      if (is_continued && from == 0)
        runs.back().high = base + length - 1;
      else
        runs.push_back({base + from, base + from + length - 1});
      is_continued = from + length == 64;
      remaining = is_continued ? 0 : remaining & (~std::uint64_t{0} << (from + length));
    }
  }
}

int Components::root_of(int run) noexcept {
  auto at = static_cast<std::size_t>(run);
  while (part_[at] != static_cast<int>(at)) {
    part_[at] = part_[static_cast<std::size_t>(part_[at])];
    at = static_cast<std::size_t>(part_[at]);
  }
  return static_cast<int>(at);
}

void Components::join_rows(std::size_t row, std::size_t other, int reach) noexcept {
  std::uint32_t a = first_[row], b = first_[other];
  const std::uint32_t a_end = first_[row + 1], b_end = first_[other + 1];
  while (a != a_end && b != b_end) {
    const Run &one = runs_[a], &two = runs_[b];
    if (one.low <= two.high + reach && two.low <= one.high + reach) {
      const int r = root_of(static_cast<int>(a)), s = root_of(static_cast<int>(b));
      if (r != s) part_[static_cast<std::size_t>(std::max(r, s))] = std::min(r, s);
    }
    // The run that ends first touches no further run.
    one.high < two.high ? ++a : ++b;
  }
}

void Components::join_runs(Connectivity touch, int threads) {
  part_.resize(runs_.size());
  const bool has_corners = touch == Connectivity::corners;
  const int reach = has_corners ? 1 : 0;
  const auto join_below = [&](int y, int z) {
    const std::size_t row = row_of(y, z);
    if (first_[row] == first_[row + 1]) return;
    for (int other = has_corners ? std::max(y - 1, 0) : y;
         other <= (has_corners ? std::min(y + 1, size_.y - 1) : y); ++other)
      join_rows(row, row_of(other, z - 1), reach);
  };
  // Join within slabs in parallel, then across their borders.
  parallel_for(slabs_of(size_.z), threads, [&](int slab) {
    const int begin = k_slab * slab, end = std::min(begin + k_slab, size_.z);
    for (std::uint32_t r = first_[row_of(0, begin)]; r < first_[row_of(0, end)]; ++r)
      part_[r] = static_cast<int>(r);
    for (int z = begin; z < end; ++z)
      for (int y = 0; y < size_.y; ++y) {
        if (y > 0) join_rows(row_of(y, z), row_of(y - 1, z), reach);
        if (z > begin) join_below(y, z);
      }
  });
  for (int z = k_slab; z < size_.z; z += k_slab)
    for (int y = 0; y < size_.y; ++y) join_below(y, z);
}

void Components::number_parts() {
  // A run that is not the root of its part refers to an earlier run, whose number is already known.
  for (std::size_t r = 0; r < runs_.size(); ++r) {
    if (part_[r] == static_cast<int>(r)) {
      part_[r] = static_cast<int>(sizes_.size());
      sizes_.push_back(0);
    } else {
      part_[r] = part_[static_cast<std::size_t>(part_[r])];
    }
    sizes_[static_cast<std::size_t>(part_[r])] += runs_[r].high - runs_[r].low + 1;
  }
}

int Components::part_of(const glm::ivec3& v) const noexcept {
  const std::size_t row = row_of(v.y, v.z);
  const Run *begin = runs_.data() + first_[row], *end = runs_.data() + first_[row + 1];
  const Run* run = std::lower_bound(begin, end, v.x, [](const Run& one, int x) { return one.high < x; });
  return run == end || run->low > v.x ? k_air : part_[static_cast<std::size_t>(run - runs_.data())];
}

std::vector<std::uint64_t> Components::flood(const glm::ivec3& seed) const {
  const int part = part_of(seed);
  if (part == k_air) return {};
  std::vector<std::uint64_t> bits(words_ * row_of(0, size_.z));
  for (std::size_t row = 0; row + 1 < first_.size(); ++row)
    for (std::uint32_t r = first_[row]; r < first_[row + 1]; ++r) {
      if (part_[r] != part) continue;
      std::uint64_t* words = bits.data() + words_ * row;
      const auto low = static_cast<std::size_t>(runs_[r].low), high = static_cast<std::size_t>(runs_[r].high);
      for (std::size_t w = low / 64; w <= high / 64; ++w) {
        std::uint64_t mask = ~std::uint64_t{0};
        if (w == low / 64) mask &= ~std::uint64_t{0} << (low % 64);
        if (w == high / 64) mask &= ~std::uint64_t{0} >> (63 - high % 64);
        words[w] |= mask;
      }
    }
  return bits;
}

}  // namespace trephine::verify
