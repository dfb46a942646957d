#include "volume/cuts/version.h"

#include <algorithm>
#include <bit>
#include <glm/common.hpp>
#include <glm/vector_relational.hpp>
#include <numeric>

#include "volume/scan/trilinear.h"

namespace trephine::volume {

RemovalMask::RemovalMask(int points_per_edge)
    : n(points_per_edge),
      words(static_cast<std::size_t>(k_brick * k_brick * k_brick * points_per_edge * points_per_edge *
                                     points_per_edge / 64)) {}

RemovalMask* RemovalMask::copy() const {
  auto* result = new RemovalMask(n);
  result->words = words;
  result->base_solid = base_solid;
  result->base_air = base_air;
  result->full = full;
  return result;
}

RemovalMask* RemovalMask::refined() const {
  TREPHINE_ASSERT(n == 4);
  auto* fine = new RemovalMask(8);
  fine->base_solid = base_solid;
  fine->base_air = base_air;
  fine->full = full;
  for (std::size_t cell = 0; cell < words.size(); ++cell) refine_points(words[cell], &fine->words[8 * cell]);
  return fine;
}

void refine_points(std::uint64_t coarse, std::uint64_t fine[8]) noexcept {
  for (unsigned k = 0; k < 4; ++k) {
    // Doubles a slice of 4 x 4 bits along each axis: repeats each bit along x, each row along y, and the
    // slice along z.
    std::uint64_t slice = 0;
    for (unsigned j = 0; j < 4; ++j) {
      const std::uint64_t row = coarse >> (16 * k + 4 * j) & 0xfu;
      const std::uint64_t wide =
          (row & 1u) * 3u | (row >> 1 & 1u) * 12u | (row >> 2 & 1u) * 48u | (row >> 3) * 192u;
      slice |= (wide | wide << 8) << (16 * j);
    }
    fine[2 * k] = fine[2 * k + 1] = slice;
  }
}

std::int64_t RemovalLedger::total() const noexcept {
  return std::accumulate(units_by_label.begin(), units_by_label.end(), std::int64_t{0});
}

Version::Version(std::shared_ptr<const Volume> base) : Version(base, CutLattice(*base)) {}

Version::Version(std::shared_ptr<const Volume> base, const CutLattice& lattice)
    : base_(std::move(base)), lattice_(lattice) {
  TREPHINE_ASSERT(lattice_.size() == base_->size * lattice_.per_voxel() + 2 * CutLattice::k_margin);
  regions_size_ = (lattice_.size() + (k_region_samples - 1)) / k_region_samples;
  regions_.resize(static_cast<std::size_t>(regions_size_.x) * static_cast<std::size_t>(regions_size_.y) *
                  static_cast<std::size_t>(regions_size_.z));
  ledger_.units_by_label.resize(std::max<std::size_t>(1, base_->label_names.size()));
  band_mm_ = 1.05 * lattice_.frame().diagonal_mm();
  auto* hollow = new Brick;
  hollow->distance.fill(-static_cast<float>(band_mm_));
  hollow->kept.fill(0);
  hollow->is_hollow = true;
  hollow_ = Ref<Brick>(hollow);
}

/// Calls each(region index, page index, brick index, Brick) in table order.
template <class Each>
void Version::for_bricks(Each&& each) const {
  for (std::size_t r = 0; r < regions_.size(); ++r) {
    if (!regions_[r]) continue;
    for (std::size_t p = 0; p < regions_[r]->pages.size(); ++p) {
      const Page* page = regions_[r]->pages[p].get();
      if (page == nullptr) continue;
      for (std::size_t b = 0; b < page->bricks.size(); ++b)
        if (page->bricks[b]) each(r, p, b, *page->bricks[b]);
    }
  }
}

std::size_t Version::bytes() const noexcept {
  std::size_t sum = sizeof(Version) + regions_.size() * sizeof(Ref<Region>) + sizeof(Brick);
  for (const auto& region : regions_) {
    if (!region) continue;
    sum += sizeof(Region);
    for (const auto& page : region->pages) sum += page ? sizeof(Page) : 0;
  }
  for_bricks([&sum](std::size_t, std::size_t, std::size_t, const Brick& brick) {
    if (brick.is_hollow) return;
    sum += sizeof(Brick) + (brick.mask ? brick.mask->words.size() * 8 + sizeof(RemovalMask) : 0);
  });
  return sum;
}

std::size_t Version::add_bytes(std::unordered_set<const void*>& counted) const {
  std::size_t sum = sizeof(Version) + regions_.size() * sizeof(Ref<Region>);
  const auto is_new = [&counted](const auto& part) { return part && counted.insert(part.get()).second; };
  for (const auto& region : regions_) {
    if (!is_new(region)) continue;
    sum += sizeof(Region);
    for (const auto& page : region->pages) {
      if (!is_new(page)) continue;
      sum += sizeof(Page);
      for (const auto& brick : page->bricks) {
        if (!is_new(brick)) continue;
        sum += sizeof(Brick);
        if (is_new(brick->mask))
          sum += sizeof(RemovalMask) + brick->mask->words.size() * sizeof(std::uint64_t);
      }
    }
  }
  return sum;
}

bool Version::has_brick(const glm::ivec3& low, const glm::ivec3& high) const noexcept {
  if (brick_count_ == 0) return false;
  const glm::ivec3 last = lattice_.size() - 1;
  if (glm::any(glm::greaterThan(low, last)) || glm::any(glm::lessThan(high, glm::ivec3(0)))) return false;
  const glm::ivec3 from = glm::max(low, glm::ivec3(0)) >> 3, to = glm::min(high, last) >> 3;
  for (int z = from.z; z <= to.z; ++z)
    for (int y = from.y; y <= to.y; ++y)
      for (int x = from.x; x <= to.x; ++x) {
        const glm::ivec3 s(8 * x, 8 * y, 8 * z);
        const Page* page = page_at(s);
        if (page == nullptr)
          x |= 7;  // skips to the next page
        else if (page->bricks[brick_index(s)])
          return true;
      }
  return false;
}

namespace {
CellCorners distance_corners(const Version& version, const glm::ivec3& c) noexcept {
  CellCorners d;
  for (int k = 0; k < 8; ++k)
    d[static_cast<std::size_t>(k)] = version.sample_distance(c + glm::ivec3(k & 1, k >> 1 & 1, k >> 2 & 1));
  return d;
}
}  // namespace

double Version::distance(const glm::dvec3& p) const noexcept {
  const CellPoint q(lattice_.lattice_from_volume(p));
  return trilinear_value(distance_corners(*this, q.cell), q.at);
}

glm::dvec3 Version::distance_gradient(const glm::dvec3& p) const noexcept {
  const CellPoint q(lattice_.lattice_from_volume(p));
  return lattice_.scale() * trilinear_gradient(distance_corners(*this, q.cell), q.at);
}

bool Version::is_near_cut(const glm::dvec3& p) const noexcept {
  if (brick_count_ == 0) return false;
  const glm::ivec3 c = CellPoint(lattice_.lattice_from_volume(p)).cell;
  return has_brick(c, c + 1);
}

double Version::removed_share(const glm::ivec3& v) const noexcept {
  const glm::ivec3 low = lattice_.low_of(v), high = lattice_.high_of(v);
  if (!has_brick(low, high)) return 0;
  double removed = 0;
  for (int z = low.z; z <= high.z; ++z)
    for (int y = low.y; y <= high.y; ++y)
      for (int x = low.x; x <= high.x; ++x) {
        const Brick* brick = brick_at({x, y, z});
        if (brick == nullptr || !(brick->mask || brick->is_hollow)) continue;
        if (brick->is_hollow) {
          removed += 1;
          continue;
        }
        const RemovalMask& mask = *brick->mask;
        const auto words = static_cast<std::size_t>(mask.words_per_cell());
        const std::uint64_t* at = mask.words.data() + words * Brick::index(x & 7, y & 7, z & 7);
        int points = 0;
        for (std::size_t w = 0; w < words; ++w) points += std::popcount(at[w]);
        removed += static_cast<double>(points) / (mask.n * mask.n * mask.n);
      }
  const glm::ivec3& k = lattice_.per_voxel();
  return removed / (k.x * k.y * k.z);
}

void Version::mask_row(int y, int z, int first_word, int count, std::uint64_t* words) const noexcept {
  if (brick_count_ == 0) return;
  for (int w = 0; w < count; ++w) {
    if (words[w] == 0 || !has_brick(y, z, first_word + w, 1)) continue;
    glm::ivec3 s = lattice_.centre_of({64 * (first_word + w), y, z});
    if (lattice_.has_voxel_resolution()) {
      for (int b = 0; b < 8; ++b, s.x += k_brick) {
        if (s.x >= lattice_.size().x) break;
        if (const Brick* brick = brick_at(s))
          words[w] &= ~((~brick->kept_row(s.y & 7, s.z & 7) & 0xffu) << (8 * b));
      }
      continue;
    }
    const Brick* brick = nullptr;
    int brick_x = -1;
    for (int b = 0; b < 64 && s.x < lattice_.size().x; ++b, s.x += lattice_.per_voxel().x) {
      if (s.x >> 3 != brick_x) {
        brick = brick_at(s);
        brick_x = s.x >> 3;
      }
      if (brick && !brick->is_kept(s.x & 7, s.y & 7, s.z & 7)) words[w] &= ~(std::uint64_t{1} << b);
    }
  }
}

bool Version::has_brick(int y, int z, int first_word, int count) const noexcept {
  return has_brick(lattice_.centre_of({64 * first_word, y, z}),
                   lattice_.centre_of({64 * (first_word + count) - 1, y, z}));
}

std::uint64_t Version::content_hash() const noexcept {
  std::uint64_t hash = 14695981039346656037ull;
  const auto add = [&hash](std::uint64_t value) { hash = (hash ^ value) * 1099511628211ull; };
  for_bricks([&](std::size_t region, std::size_t page, std::size_t index, const Brick& brick) {
    add(region);
    add(page);
    add(index);
    if (brick.is_hollow) return;
    for (const float d : brick.distance) add(std::bit_cast<std::uint32_t>(d));
    for (const std::uint64_t slice : brick.kept) add(slice);
    if (brick.mask)
      for (const auto* slices : {&brick.mask->base_solid, &brick.mask->base_air})
        for (const std::uint64_t slice : *slices) add(slice);
    if (brick.mask)
      for (const std::uint64_t word : brick.mask->words) add(word);
  });
  return hash;
}

}  // namespace trephine::volume
