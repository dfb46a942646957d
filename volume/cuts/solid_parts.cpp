#include "volume/cuts/solid_parts.h"

#include <algorithm>
#include <bit>
#include <glm/common.hpp>
#include <glm/vector_relational.hpp>
#include <numeric>

namespace trephine::volume {

namespace {

/// Disjoint sets; the root of a set is its lowest number.
class Sets {
 public:
  explicit Sets(std::size_t count) : parent_(count) { std::iota(parent_.begin(), parent_.end(), 0); }
  int root(int i) noexcept {
    auto at = static_cast<std::size_t>(i);
    while (parent_[at] != static_cast<int>(at)) {
      parent_[at] = parent_[static_cast<std::size_t>(parent_[at])];
      at = static_cast<std::size_t>(parent_[at]);
    }
    return static_cast<int>(at);
  }
  void join(int a, int b) noexcept {
    a = root(a), b = root(b);
    parent_[static_cast<std::size_t>(std::max(a, b))] = std::min(a, b);
  }
  std::vector<int> roots() {
    std::vector<int> result(parent_.size());
    for (std::size_t i = 0; i < result.size(); ++i) result[i] = root(static_cast<int>(i));
    return result;
  }

 private:
  std::vector<int> parent_;
};

/// Calls meet(a, b) for runs of two rows that overlap or touch, also at corners.
template <class Runs, class Meet>
void for_meeting(const Runs& row_a, const Runs& row_b, Meet&& meet) {
  const auto* b = row_b.begin;
  for (const auto* a = row_a.begin; a != row_a.end; ++a) {
    while (b != row_b.end && b->high + 1 < a->low) ++b;
    for (const auto* next = b; next != row_b.end && next->low <= a->high + 1; ++next) meet(*a, *next);
  }
}

}  // namespace

SolidParts::SolidParts(const Field& field, const Occupancy& bits, const Version& version)
    : version_(&version),
      lattice_(version.lattice()),
      size_(version.base().size),
      words_(static_cast<std::size_t>(bits.words_per_row())) {
  find_fine_voxels();
  find_parts(field, bits);
  if (!lattice_.has_voxel_resolution() && refine_surfaces(bits)) find_parts(field, bits);
  version_ = nullptr;
}

void SolidParts::find_parts(const Field& field, const Occupancy& bits) {
  coarse_runs_.clear(), fine_runs_.clear(), parts_.clear();
  coarse_first_.clear(), fine_first_.clear(), fine_row_index_.clear();
  for (int z = 0; z < size_.z; ++z)
    for (int y = 0; y < size_.y; ++y) {
      coarse_first_.push_back(coarse_runs_.size());
      add_coarse_runs(bits, y, z);
      add_fine_runs(field, y, z);
    }
  coarse_first_.push_back(coarse_runs_.size());
  fine_first_.push_back(fine_runs_.size());
  for (std::size_t r = 0; r < coarse_runs_.size(); ++r) coarse_runs_[r].part = static_cast<int>(r);
  for (std::size_t r = 0; r < fine_runs_.size(); ++r)
    fine_runs_[r].part = static_cast<int>(coarse_runs_.size() + r);

  Sets sets(coarse_runs_.size() + fine_runs_.size());
  for_neighbours([&](const Run& a, const Run& b) {
    if (!a.is_removed && !b.is_removed) sets.join(a.part, b.part);
  });
  std::vector<int> part_of_run = sets.roots();
  for_neighbours([&](const Run& a, const Run& b) { sets.join(a.part, b.part); });
  std::vector<int> whole_of_run = sets.roots();
  number_parts(part_of_run, whole_of_run);
}

/// Marks surface voxels as fine: those that differ from a neighbour, in the boxes of detached parts and up to
/// two voxels around these boxes. Returns false if no voxel was marked.
bool SolidParts::refine_surfaces(const Occupancy& bits) {
  const auto is_solid = [&](const glm::ivec3& v) {
    return glm::all(glm::greaterThanEqual(v, glm::ivec3(0))) && glm::all(glm::lessThan(v, size_)) &&
           bits.is_solid(v);
  };
  bool is_any = false;
  for (const Part& part : parts_) {
    if (!part.is_detached) continue;
    const glm::ivec3 low = glm::max(part.box.low - 2, glm::ivec3(0)),
                     high = glm::min(part.box.high + 2, size_ - 1);
    for (int z = low.z; z <= high.z; ++z)
      for (int y = low.y; y <= high.y; ++y)
        for (int x = low.x; x <= high.x; ++x) {
          std::uint64_t& word = is_fine_[words_ * row_index(y, z) + static_cast<std::size_t>(x >> 6)];
          const std::uint64_t bit = std::uint64_t{1} << (x & 63);
          if ((word & bit) != 0) continue;
          const bool is_centre_solid = is_solid({x, y, z});
          for (int n = 0; n < 27; ++n)
            if (is_solid(glm::ivec3(x, y, z) + glm::ivec3(n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1)) !=
                is_centre_solid) {
              word |= bit;
              is_any = true;
              break;
            }
        }
  }
  return is_any;
}

void SolidParts::find_fine_voxels() {
  is_fine_.resize(words_ * row_index(0, size_.z));
  version_->for_bricks_in(glm::ivec3(0), lattice_.size() - 1, [&](const glm::ivec3& first, const Brick&) {
    const glm::ivec3 low = glm::max(lattice_.voxel_of(first), glm::ivec3(0)),
                     high = glm::min(lattice_.voxel_of(first + (k_brick - 1)), size_ - 1);
    for (int z = low.z; z <= high.z; ++z)
      for (int y = low.y; y <= high.y; ++y)
        for (int x = low.x; x <= high.x; ++x)
          is_fine_[words_ * row_index(y, z) + static_cast<std::size_t>(x >> 6)] |= std::uint64_t{1}
                                                                                   << (x & 63);
  });
}

void SolidParts::add_coarse_runs(const Occupancy& bits, int y, int z) {
  const std::uint64_t *row = bits.row(y, z), *fine = is_fine_.data() + words_ * row_index(y, z);
  bool is_continued = false;
  for (std::size_t w = 0; w < words_; ++w) {
    const int base = 64 * static_cast<int>(w);
    for (std::uint64_t remaining = row[w] & ~fine[w]; remaining != 0;) {
      const int from = std::countr_zero(remaining), length = std::countr_one(remaining >> from);
      if (from == 0 && is_continued)
        coarse_runs_.back().high = base + length - 1;
      else
        coarse_runs_.push_back({base + from, base + from + length - 1, 0});
      if (from + length == 64) break;
      remaining &= ~std::uint64_t{0} << (from + length);
    }
    is_continued = ((row[w] & ~fine[w]) >> 63) != 0;
  }
}

void SolidParts::add_fine_runs(const Field& field, int y, int z) {
  const std::uint64_t* fine = is_fine_.data() + words_ * row_index(y, z);
  if (std::all_of(fine, fine + words_, [](std::uint64_t word) { return word == 0; })) {
    fine_row_index_.push_back(-1);
    return;
  }
  const glm::ivec3& k = lattice_.per_voxel();
  fine_row_index_.push_back(static_cast<int>(fine_first_.size()));
  const glm::ivec3 low = lattice_.low_of({0, y, z});
  for (int j = 0; j < k.z; ++j)
    for (int i = 0; i < k.y; ++i) {
      fine_first_.push_back(fine_runs_.size());
      const std::size_t first = fine_runs_.size();
      for (std::size_t w = 0; w < words_; ++w)
        for (std::uint64_t remaining = fine[w]; remaining != 0; remaining &= remaining - 1) {
          const int x = 64 * static_cast<int>(w) + std::countr_zero(remaining);
          glm::ivec3 s(low.x + k.x * x, low.y + i, low.z + j);
          for (const int end = s.x + k.x; s.x < end; ++s.x) {
            if (field.value(lattice_.volume_from_lattice(glm::dvec3(s))) < 0) continue;
            const bool is_removed = !(version_->sample_distance(s) > 0);
            if (fine_runs_.size() > first && fine_runs_.back().high == s.x - 1 &&
                fine_runs_.back().is_removed == is_removed)
              ++fine_runs_.back().high;
            else
              fine_runs_.push_back({s.x, s.x, 0, is_removed});
          }
        }
    }
}

SolidParts::Runs SolidParts::coarse_row(int y, int z) const noexcept {
  if (!is_in_grid(y, z)) return {nullptr, nullptr};
  const std::size_t row = row_index(y, z);
  return {coarse_runs_.data() + coarse_first_[row], coarse_runs_.data() + coarse_first_[row + 1]};
}

SolidParts::Runs SolidParts::fine_row(int y, int z) const noexcept {
  const glm::ivec3 v = lattice_.voxel_of({0, y, z});
  if (!is_in_grid(v.y, v.z) || fine_row_index_[row_index(v.y, v.z)] < 0) return {nullptr, nullptr};
  const glm::ivec3 low = lattice_.low_of(v);
  const auto at = static_cast<std::size_t>(fine_row_index_[row_index(v.y, v.z)] + (y - low.y) +
                                           lattice_.per_voxel().y * (z - low.z));
  return {fine_runs_.data() + fine_first_[at], fine_runs_.data() + fine_first_[at + 1]};
}

/// Calls join(a, b) for all runs that touch each other, each pair at least once.
template <class Join>
void SolidParts::for_neighbours(Join&& join) const {
  constexpr glm::ivec2 k_before[] = {{-1, -1}, {0, -1}, {1, -1}, {-1, 0}};  // neighbours that precede a row
  const glm::ivec3& k = lattice_.per_voxel();
  for (int z = 0; z < size_.z; ++z)
    for (int y = 0; y < size_.y; ++y) {
      for (const glm::ivec2& d : k_before) for_meeting(coarse_row(y, z), coarse_row(y + d.x, z + d.y), join);
      if (fine_row_index_[row_index(y, z)] < 0) continue;
      const glm::ivec3 low = lattice_.low_of({0, y, z});
      for (int fz = low.z; fz < low.z + k.z; ++fz)
        for (int fy = low.y; fy < low.y + k.y; ++fy) {
          const Runs samples = fine_row(fy, fz);
          for (const Run* run = samples.begin; run != samples.end; ++run)
            if (run + 1 != samples.end && run->high + 1 == run[1].low) join(*run, run[1]);
          for (const glm::ivec2& d : k_before) for_meeting(samples, fine_row(fy + d.x, fz + d.y), join);
          // Rows of voxels that contain this row of samples and its eight neighbouring rows.
          const glm::ivec3 from = lattice_.voxel_of({0, fy - 1, fz - 1}),
                           to = lattice_.voxel_of({0, fy + 1, fz + 1});
          for (int vz = from.z; vz <= to.z; ++vz)
            for (int vy = from.y; vy <= to.y; ++vy) {
              const Runs voxels = coarse_row(vy, vz);
              for (const Run* run = samples.begin; run != samples.end; ++run) {
                const Run* other = std::partition_point(voxels.begin, voxels.end, [&](const Run& r) {
                  return lattice_.high_of({r.high, 0, 0}).x < run->low - 1;
                });
                for (; other != voxels.end && lattice_.low_of({other->low, 0, 0}).x <= run->high + 1; ++other)
                  join(*run, *other);
              }
            }
        }
    }
}

/// Numbers the parts and finds which are detached. `part_of_run`: root of each run if only runs that are not
/// removed are joined. `whole_of_run`: root of each run if removed runs are joined too; it is equal for all
/// parts that were one part before the cuts.
void SolidParts::number_parts(std::vector<int>& part_of_run, std::vector<int>& whole_of_run) {
  const glm::ivec3& k = lattice_.per_voxel();
  // Collects the parts, then sorts them by their first samples.
  struct Candidate {
    std::int64_t first, samples = 0;
    VoxelBox box;
    int whole;
  };
  std::vector<Candidate> candidates;
  std::vector<int> number(part_of_run.size(), k_air);
  const auto index_of = [this](const glm::ivec3& s) {
    return s.x + static_cast<std::int64_t>(lattice_.size().x) *
                     (s.y + static_cast<std::int64_t>(lattice_.size().y) * s.z);
  };
  const auto add = [&](const Run& run, const glm::ivec3& first, std::int64_t samples, const VoxelBox& box) {
    const auto r = static_cast<std::size_t>(run.part);
    int& n = number[static_cast<std::size_t>(part_of_run[r])];
    if (n == k_air) {
      n = static_cast<int>(candidates.size());
      candidates.push_back({index_of(first), 0, box, whole_of_run[r]});
    }
    Candidate& part = candidates[static_cast<std::size_t>(n)];
    part.first = std::min(part.first, index_of(first));
    part.samples += samples;
    part.box = {glm::min(part.box.low, box.low), glm::max(part.box.high, box.high)};
  };
  for (int z = 0; z < size_.z; ++z)
    for (int y = 0; y < size_.y; ++y) {
      const Runs voxels = coarse_row(y, z);
      for (const Run* run = voxels.begin; run != voxels.end; ++run)
        add(*run, lattice_.low_of({run->low, y, z}), std::int64_t{run->high - run->low + 1} * k.x * k.y * k.z,
            {{run->low, y, z}, {run->high, y, z}});
      if (fine_row_index_[row_index(y, z)] < 0) continue;
      const glm::ivec3 low = lattice_.low_of({0, y, z});
      for (int fz = low.z; fz < low.z + k.z; ++fz)
        for (int fy = low.y; fy < low.y + k.y; ++fy) {
          const Runs samples = fine_row(fy, fz);
          for (const Run* run = samples.begin; run != samples.end; ++run)
            if (!run->is_removed)
              add(*run, {run->low, fy, fz}, run->high - run->low + 1,
                  {lattice_.voxel_of({run->low, fy, fz}), lattice_.voxel_of({run->high, fy, fz})});
        }
    }
  std::vector<int> order(candidates.size()), part_number(candidates.size());
  std::iota(order.begin(), order.end(), 0);
  const auto candidate = [&](int i) -> Candidate& { return candidates[static_cast<std::size_t>(i)]; };
  std::sort(order.begin(), order.end(),
            [&](int a, int b) { return candidate(a).first < candidate(b).first; });
  // Among the parts with the same root in `whole_of_run`, all except the largest are detached.
  std::vector<int> largest(whole_of_run.size(), k_air);
  for (const int i : order) {
    int& best = largest[static_cast<std::size_t>(candidate(i).whole)];
    if (best == k_air || candidate(i).samples > candidate(best).samples) best = i;
  }
  for (const int i : order) {
    part_number[static_cast<std::size_t>(i)] = static_cast<int>(parts_.size());
    parts_.push_back(
        {candidate(i).samples, candidate(i).box, largest[static_cast<std::size_t>(candidate(i).whole)] != i});
  }
  const auto set_part = [&](Run& run) {
    const int n = number[static_cast<std::size_t>(part_of_run[static_cast<std::size_t>(run.part)])];
    run.part = run.is_removed || n == k_air ? k_air : part_number[static_cast<std::size_t>(n)];
  };
  for (Run& run : coarse_runs_) set_part(run);
  for (Run& run : fine_runs_) set_part(run);
}

void SolidParts::row(int x, int y, int z, int count, int* parts) const noexcept {
  std::fill_n(parts, count, k_air);
  const glm::ivec3 v = lattice_.voxel_of({0, y, z});
  if (!is_in_grid(v.y, v.z)) return;
  const auto fill = [&](int low, int high, int part) {
    for (int s = std::max(low, x); s <= std::min(high, x + count - 1); ++s) parts[s - x] = part;
  };
  const Runs samples = fine_row(y, z), voxels = coarse_row(v.y, v.z);
  const Run* run = std::partition_point(samples.begin, samples.end, [x](const Run& r) { return r.high < x; });
  for (; run != samples.end && run->low < x + count; ++run) fill(run->low, run->high, run->part);
  run = std::partition_point(voxels.begin, voxels.end, [&](const Run& r) {
    return lattice_.high_of({r.high, 0, 0}).x < x;
  });
  for (; run != voxels.end && lattice_.low_of({run->low, 0, 0}).x < x + count; ++run)
    fill(lattice_.low_of({run->low, 0, 0}).x, lattice_.high_of({run->high, 0, 0}).x, run->part);
}

}  // namespace trephine::volume
