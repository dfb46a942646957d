// The operated state of a volume: an immutable table of small bricks of a cut lattice that hold, only near
// cuts, what was removed.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <glm/common.hpp>
#include <glm/vec3.hpp>
#include <glm/vector_relational.hpp>
#include <memory>
#include <unordered_set>
#include <utility>
#include <vector>

#include "volume/cut_lattice.h"
#include "volume/volume.h"

namespace trephine::volume {

/// Shared ownership of an immutable T with a `references` counter inside; one pointer wide.
template <class T>
class Ref {
 public:
  Ref() = default;
  explicit Ref(T* owned) noexcept : object_(owned) {}  ///< takes the first reference
  Ref(const Ref& other) noexcept : object_(other.object_) {
    if (object_) object_->references.fetch_add(1, std::memory_order_relaxed);
  }
  Ref(Ref&& other) noexcept : object_(std::exchange(other.object_, nullptr)) {}
  Ref& operator=(Ref other) noexcept {
    std::swap(object_, other.object_);
    return *this;
  }
  ~Ref() {
    if (object_ && object_->references.fetch_sub(1, std::memory_order_acq_rel) == 1) delete object_;
  }
  T* get() const noexcept { return object_; }
  T* operator->() const noexcept { return object_; }
  T& operator*() const noexcept { return *object_; }
  explicit operator bool() const noexcept { return object_ != nullptr; }

 private:
  T* object_ = nullptr;
};

/// Samples of the cut lattice along the edge of a brick, bricks along that of a page, pages along that of a
/// region.
inline constexpr int k_brick = 8;
inline constexpr int k_page = 8;
inline constexpr int k_page_samples = k_brick * k_page;
inline constexpr int k_region_samples = k_page_samples * k_page;

inline constexpr int k_point_turns = 1024;
/// Shift of the points of the cell around a sample, -0.5 to 0.5 of their step along each axis: each
/// cell's by its own amount, or they would stand in rows, and a hole along these be counted by few.
constexpr float point_shift(std::int32_t turn) noexcept {
  return (static_cast<float>(turn) - 511.5f) / 1024.0f;
}
/// 0 to k_point_turns - 1 along each axis; of a sum of samples the sum, turned on.
constexpr glm::uvec3 point_turn(const glm::ivec3& sample) noexcept {
  // Found by trial: of 300 the one whose worst capsule along 15 directions is counted best.
  const glm::uvec3 s(sample);
  return {(237u * s.x + 499u * s.y + 327u * s.z) % k_point_turns,
          (247u * s.x + 59u * s.y + 631u * s.z) % k_point_turns,
          (709u * s.x + 861u * s.y + 993u * s.z) % k_point_turns};
}
inline glm::vec3 point_shift(const glm::ivec3& sample) noexcept {
  const glm::ivec3 turn(point_turn(sample));
  return {point_shift(turn.x), point_shift(turn.y), point_shift(turn.z)};
}

/// Removed points of each lattice cell (the cube around a sample): n^3 bits a cell, n = 4 or 8,
/// point (i, j, k) at ((i + 0.5) + point_shift) / n - 0.5 steps from the sample. Only edits and ledgers read
/// it.
struct RemovalMask {
  explicit RemovalMask(int samples_per_edge);
  std::atomic<int> references{1};
  std::uint64_t stroke = 0;  ///< the stroke that may still write it
  int n;
  std::vector<std::uint64_t> words;  ///< words_per_cell() for each cell of the brick, x fastest
  /// Cells that are wholly solid (or air) in the base, laid out as Brick::kept: spares the ledger's points.
  std::array<std::uint64_t, k_brick> base_solid{}, base_air{};
  /// Cells all of whose points are removed, laid out as Brick::kept.
  std::array<std::uint64_t, k_brick> full{};

  int words_per_cell() const noexcept { return n * n * n / 64; }
  RemovalMask* copy() const;
  /// The points at twice the fineness (4 -> 8).
  RemovalMask* refined() const;
};

/// Each bit of a word of 4^3 points as the 2^3 of 8^3 points in its place.
void refine_points(std::uint64_t coarse, std::uint64_t fine[8]) noexcept;

/// 8 x 8 x 8 samples near a cut. Immutable once its version is published.
struct Brick {
  std::atomic<int> references{1};
  std::uint64_t serial = 0;                                 ///< the version that made it
  std::array<float, k_brick * k_brick * k_brick> distance;  ///< mm to the swept tool, negative inside
  std::array<std::uint64_t, k_brick> kept;                  ///< a slice each, byte = row, bit = x: d > 0
  Ref<RemovalMask> mask;
  /// Every cell lies deep inside the removal: nothing is left to change. All such bricks of a volume are one,
  /// without a mask.
  bool is_hollow = false;

  static constexpr std::size_t index(int x, int y, int z) noexcept {
    return static_cast<std::size_t>((z * k_brick + y) * k_brick + x);
  }
  bool is_kept(int x, int y, int z) const noexcept {
    return kept[static_cast<std::size_t>(z)] >> (y * k_brick + x) & 1u;
  }
  std::uint64_t kept_row(int y, int z) const noexcept {
    return kept[static_cast<std::size_t>(z)] >> (y * k_brick) & 0xffu;
  }
};

/// 8 x 8 x 8 bricks.
struct Page {
  std::atomic<int> references{1};
  std::uint64_t serial = 0;
  std::array<Ref<Brick>, k_page * k_page * k_page> bricks;
};

/// 8 x 8 x 8 pages.
struct Region {
  std::atomic<int> references{1};
  std::uint64_t serial = 0;
  std::array<Ref<Page>, k_page * k_page * k_page> pages;
};

/// Removed matter so far, in whole points: 512 units are one cell of the cut lattice.
struct RemovalLedger {
  static constexpr std::int64_t k_units_per_cell = 512;
  std::vector<std::int64_t> units_by_label;  ///< at least one entry; index is the label, 0 without labels
  std::int64_t freed_units = 0;              ///< in addition: went as whole parts
  std::int64_t total() const noexcept;
};

/// One state of the operated volume. Immutable when published; readers need no lock.
class Version {
 public:
  /// The volume untouched, to be cut on its own voxels.
  explicit Version(std::shared_ptr<const Volume> base);
  /// The volume untouched. `lattice`: of this volume.
  Version(std::shared_ptr<const Volume> base, const CutLattice& lattice);

  const Volume& base() const noexcept { return *base_; }
  const std::shared_ptr<const Volume>& shared_base() const noexcept { return base_; }
  const CutLattice& lattice() const noexcept { return lattice_; }
  std::uint64_t serial() const noexcept { return serial_; }
  bool is_untouched() const noexcept { return brick_count_ == 0; }
  int brick_count() const noexcept { return brick_count_; }
  const RemovalLedger& ledger() const noexcept { return ledger_; }
  /// Size of so many units of the ledger, mm^3.
  double mm3_of(std::int64_t units) const noexcept {
    return static_cast<double>(units) / static_cast<double>(RemovalLedger::k_units_per_cell) *
           lattice_.frame().voxel_mm3();
  }
  double band_mm() const noexcept { return band_mm_; }
  std::size_t bytes() const noexcept;  ///< of tables, bricks and masks
  /// Bytes of tables that are not among `seen`, to which they are added: what versions share counts once.
  std::size_t add_bytes(std::unordered_set<const void*>& seen) const;

  /// The page that holds a sample, or null where nothing was cut. The sample lies inside the lattice.
  const Page* page_at(const glm::ivec3& s) const noexcept {
    const Region* region = regions_[region_index(s)].get();
    return region ? region->pages[page_index(s)].get() : nullptr;
  }
  /// The brick that holds a sample, or null where nothing was cut.
  const Brick* brick_at(const glm::ivec3& s) const noexcept {
    const Page* page = page_at(s);
    return page ? page->bricks[brick_index(s)].get() : nullptr;
  }
  /// Is there a brick with any of the samples low .. high? Those beyond the lattice do not count.
  bool has_brick(const glm::ivec3& low, const glm::ivec3& high) const noexcept;
  /// Calls each(first sample, Brick) for the bricks with any of the samples low .. high, by rising place.
  template <class Each>
  void for_bricks_in(const glm::ivec3& low, const glm::ivec3& high, Each&& each) const {
    const glm::ivec3 first = glm::max(low, glm::ivec3(0)), last = glm::min(high, lattice_.size() - 1);
    if (brick_count_ == 0 || glm::any(glm::greaterThan(first, last))) return;
    // The parts 0 .. 7 along each axis of what begins at `from`, each `edge` samples long, that hold any of
    // them.
    const auto for_parts = [&](const glm::ivec3& from, int edge, auto&& visit) {
      const glm::ivec3 a = glm::max((first - from) / edge, glm::ivec3(0)),
                       b = glm::min((last - from) / edge, glm::ivec3(7));
      for (int z = a.z; z <= b.z; ++z)
        for (int y = a.y; y <= b.y; ++y)
          for (int x = a.x; x <= b.x; ++x) visit(from + edge * glm::ivec3(x, y, z), in_eight(x, y, z));
    };
    const glm::ivec3 region_low = first >> 9, region_high = last >> 9;
    for (int z = region_low.z; z <= region_high.z; ++z)
      for (int y = region_low.y; y <= region_high.y; ++y)
        for (int x = region_low.x; x <= region_high.x; ++x) {
          const glm::ivec3 corner = k_region_samples * glm::ivec3(x, y, z);
          const Region* region = regions_[region_index(corner)].get();
          if (region == nullptr) continue;
          for_parts(corner, k_page_samples, [&](const glm::ivec3& of_page, std::size_t p) {
            const Page* page = region->pages[p].get();
            if (page == nullptr) return;
            for_parts(of_page, k_brick, [&](const glm::ivec3& of_brick, std::size_t b) {
              if (page->bricks[b]) each(of_brick, *page->bricks[b]);
            });
          });
        }
  }
  /// Distance (mm) of a sample to the swept tool, clamped to +-band; +band where nothing was cut or beyond
  /// the lattice.
  double distance_of(const glm::ivec3& s) const noexcept {
    if (!lattice_.contains(s)) return band_mm_;
    const Brick* brick = brick_at(s);
    return brick ? static_cast<double>(brick->distance[Brick::index(s.x & 7, s.y & 7, s.z & 7)]) : band_mm_;
  }

  /// Is the voxel's centre outside every removal (d > 0)? v lies inside the grid.
  bool is_kept(const glm::ivec3& v) const noexcept {
    const glm::ivec3 s = lattice_.centre_of(v);
    const Brick* brick = brick_at(s);
    return brick == nullptr || brick->is_kept(s.x & 7, s.y & 7, s.z & 7);
  }
  /// The distance at a voxel's centre, anywhere.
  double distance_at(int x, int y, int z) const noexcept {
    return distance_of(lattice_.centre_of({x, y, z}));
  }
  /// Trilinear distance between samples at p (volume frame).
  double distance(const glm::dvec3& p) const noexcept;
  /// Gradient of the trilinear distance, mm per voxel step.
  glm::dvec3 distance_gradient(const glm::dvec3& p) const noexcept;
  /// Is there a brick in the cell of p or touching it?
  bool is_near_cut(const glm::dvec3& p) const noexcept;
  /// May threads other than the edit thread read masks (removed_share(), content_hash())? Those of an
  /// unfrozen version change while its stroke goes on; all the rest of a version never does.
  bool is_frozen() const noexcept {
    return !frozen_strokes_ || stroke_ <= frozen_strokes_->load(std::memory_order_acquire);
  }
  /// The share of a voxel's cube that was removed, 0 to 1, by the masks.
  double removed_share(const glm::ivec3& v) const noexcept;
  /// ANDs is_kept() of `count` words (64 voxels each) of row (y, z), from `first_word` on, into `words`.
  void mask_row(int y, int z, int first_word, int count, std::uint64_t* words) const noexcept;

  /// May mask_row change those words of row (y, z)?
  bool has_brick(int y, int z, int first_word, int count) const noexcept;

  /// Hash (FNV-1a, 64 bit) of everything removed: distances, kept bits and masks with what they know of the
  /// base. Equal states, equal hash.
  std::uint64_t content_hash() const noexcept;

 private:
  friend class RemovalEditor;
  friend class VersionChanges;
  static std::size_t in_eight(int x, int y, int z) noexcept {
    return static_cast<std::size_t>((x & 7) + 8 * ((y & 7) + 8 * (z & 7)));
  }
  std::size_t region_index(const glm::ivec3& s) const noexcept {
    return static_cast<std::size_t>((s.x >> 9) +
                                    regions_size_.x * ((s.y >> 9) + regions_size_.y * (s.z >> 9)));
  }
  static std::size_t page_index(const glm::ivec3& s) noexcept {
    return in_eight(s.x >> 6, s.y >> 6, s.z >> 6);
  }
  static std::size_t brick_index(const glm::ivec3& s) noexcept {
    return in_eight(s.x >> 3, s.y >> 3, s.z >> 3);
  }
  template <class Each>
  void for_bricks(Each&& each) const;

  std::shared_ptr<const Volume> base_;
  CutLattice lattice_;
  glm::ivec3 regions_size_;
  std::vector<Ref<Region>> regions_;
  Ref<Brick> hollow_;  ///< what every hollow brick is
  RemovalLedger ledger_;
  std::shared_ptr<const std::atomic<std::uint64_t>> frozen_strokes_;  ///< the editor's; null: never edited
  double band_mm_;
  int brick_count_ = 0;
  std::uint64_t serial_ = 0;
  std::uint64_t stroke_ = 0;  ///< the last that wrote its masks
};

}  // namespace trephine::volume
