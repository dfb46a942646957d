// Version: immutable state of an operated volume. A sparse table has bricks of the cut lattice near cuts; the
// bricks store the removed matter.
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

#include "volume/cuts/cut_lattice.h"
#include "volume/scan/volume.h"

namespace trephine::volume {

/// Intrusive shared pointer, one pointer wide: T contains the counter `references`.
template <class T>
class Ref {
 public:
  Ref() = default;
  explicit Ref(T* owned) noexcept : object_(owned) {}  ///< adopts the first reference
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

/// Three levels of a table. Along each edge a brick has k_brick samples, a page k_page bricks, and a region
/// k_page pages.
inline constexpr int k_brick = 8;
inline constexpr int k_page = 8;
inline constexpr int k_page_samples = k_brick * k_page;
inline constexpr int k_region_samples = k_page_samples * k_page;

inline constexpr int k_point_shift_count = 1024;
/// Returns the shift of the points of a cell (RemovalMask) along one axis, -0.5 to 0.5 of their spacing.
/// Cells have different shifts: rows of points that continue through many cells would give a wrong volume for
/// a hole parallel to the rows. `index`: one component of point_shift_index().
constexpr float point_shift(std::int32_t index) noexcept {
  return (static_cast<float>(index) - 511.5f) / 1024.0f;
}
/// Returns the shift index of the cell around a sample, 0 to k_point_shift_count - 1 along each axis. It is
/// linear in the sample, modulo k_point_shift_count.
constexpr glm::uvec3 point_shift_index(const glm::ivec3& sample) noexcept {
  // Among 300 random choices of the factors, this choice has the smallest worst error of the counted volume
  // of capsules along 15 directions.
  const glm::uvec3 s(sample);
  return {(237u * s.x + 499u * s.y + 327u * s.z) % k_point_shift_count,
          (247u * s.x + 59u * s.y + 631u * s.z) % k_point_shift_count,
          (709u * s.x + 861u * s.y + 993u * s.z) % k_point_shift_count};
}
inline glm::vec3 point_shift(const glm::ivec3& sample) noexcept {
  const glm::ivec3 index(point_shift_index(sample));
  return {point_shift(index.x), point_shift(index.y), point_shift(index.z)};
}

/// Removed points of each lattice cell (the cube around a sample): n^3 bits per cell, n = 4 or 8, point
/// (i, j, k) at ((i + 0.5) + point_shift) / n - 0.5 steps from the sample. Contact and display do not read
/// masks.
struct RemovalMask {
  explicit RemovalMask(int points_per_edge);
  std::atomic<int> references{1};
  std::uint64_t stroke = 0;          ///< stroke that may still write it
  int n;                             ///< points along the edge of a cell: 4 or 8
  std::vector<std::uint64_t> words;  ///< words_per_cell() for each cell of the brick, x fastest
  /// Cells that are completely solid, or completely air, in the base, laid out as Brick::kept. Their points
  /// need no evaluation.
  std::array<std::uint64_t, k_brick> base_solid{}, base_air{};
  /// Completely removed cells, laid out as Brick::kept.
  std::array<std::uint64_t, k_brick> full{};

  int words_per_cell() const noexcept { return n * n * n / 64; }
  RemovalMask* copy() const;
  /// Returns a copy at twice the resolution (n = 4 to 8).
  RemovalMask* refined() const;
};

/// Replicates each bit of a word of 4^3 points to the corresponding 2^3 of 8^3 points.
void refine_points(std::uint64_t coarse, std::uint64_t fine[8]) noexcept;

/// 8 x 8 x 8 samples near a cut. Immutable once its version is published, except for the mask.
struct Brick {
  std::atomic<int> references{1};
  std::uint64_t serial = 0;                                 ///< version that made it
  std::array<float, k_brick * k_brick * k_brick> distance;  ///< mm to the removed matter, negative inside
  std::array<std::uint64_t, k_brick> kept;                  ///< distance > 0: word = z, byte = y, bit = x
  Ref<RemovalMask> mask;
  /// True if every cell is deep inside the removal, so that further cuts change nothing. All such bricks of a
  /// volume share one object, without a mask.
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

/// Removed matter so far, in integer units: 512 units are one cell of the cut lattice.
struct RemovalLedger {
  static constexpr std::int64_t k_units_per_cell = 512;
  std::vector<std::int64_t> units_by_label;  ///< at least one entry; index is the label, 0 without labels
  std::int64_t detached_units = 0;           ///< matter of detached bodies, not included in units_by_label
  std::int64_t total() const noexcept;       ///< sum over labels, without detached_units
};

/// One state of the operated volume. Immutable when published (masks: see is_frozen()); readers need no lock.
class Version {
 public:
  /// Makes the initial version, without cuts, with one sample per voxel.
  explicit Version(std::shared_ptr<const Volume> base);
  /// Makes the initial version, without cuts. `lattice` must belong to this volume.
  Version(std::shared_ptr<const Volume> base, const CutLattice& lattice);

  const Volume& base() const noexcept { return *base_; }
  const std::shared_ptr<const Volume>& shared_base() const noexcept { return base_; }
  const CutLattice& lattice() const noexcept { return lattice_; }
  std::uint64_t serial() const noexcept { return serial_; }
  bool is_uncut() const noexcept { return brick_count_ == 0; }
  int brick_count() const noexcept { return brick_count_; }
  const RemovalLedger& ledger() const noexcept { return ledger_; }
  /// Volume of ledger units, mm^3.
  double mm3_of(std::int64_t units) const noexcept {
    return static_cast<double>(units) / static_cast<double>(RemovalLedger::k_units_per_cell) *
           lattice_.frame().voxel_mm3();
  }
  /// Distances are clamped to +-band, a little more than a lattice cell's diagonal.
  double band_mm() const noexcept { return band_mm_; }
  std::size_t bytes() const noexcept;  ///< size of tables, bricks and masks
  /// Returns the bytes of the tables, bricks and masks that are not in `counted`, and adds these objects to
  /// `counted`, so that objects shared by several versions count once.
  std::size_t add_bytes(std::unordered_set<const void*>& counted) const;

  /// Returns the page that contains a sample, or null where nothing was cut. Requires a sample inside the
  /// lattice.
  const Page* page_at(const glm::ivec3& s) const noexcept {
    const Region* region = regions_[region_index(s)].get();
    return region ? region->pages[page_index(s)].get() : nullptr;
  }
  /// Returns the brick that contains a sample, or null where nothing was cut. Requires a sample inside the
  /// lattice.
  const Brick* brick_at(const glm::ivec3& s) const noexcept {
    const Page* page = page_at(s);
    return page ? page->bricks[brick_index(s)].get() : nullptr;
  }
  /// Returns true if a brick contains any of the samples low .. high; ignores samples beyond the lattice.
  bool has_brick(const glm::ivec3& low, const glm::ivec3& high) const noexcept;
  /// Calls each(first sample, Brick) for the bricks with any of the samples low .. high, in table order.
  template <class Each>
  void for_bricks_in(const glm::ivec3& low, const glm::ivec3& high, Each&& each) const {
    const glm::ivec3 first = glm::max(low, glm::ivec3(0)), last = glm::min(high, lattice_.size() - 1);
    if (brick_count_ == 0 || glm::any(glm::greaterThan(first, last))) return;
    // Calls visit(first sample, index) for the 8 x 8 x 8 children of the table at `corner` that contain any
    // of the samples low .. high. `edge`: samples along the edge of a child.
    const auto for_children = [&](const glm::ivec3& corner, int edge, auto&& visit) {
      const glm::ivec3 a = glm::max((first - corner) / edge, glm::ivec3(0)),
                       b = glm::min((last - corner) / edge, glm::ivec3(7));
      for (int z = a.z; z <= b.z; ++z)
        for (int y = a.y; y <= b.y; ++y)
          for (int x = a.x; x <= b.x; ++x) visit(corner + edge * glm::ivec3(x, y, z), child_index(x, y, z));
    };
    const glm::ivec3 region_low = first >> 9, region_high = last >> 9;
    for (int z = region_low.z; z <= region_high.z; ++z)
      for (int y = region_low.y; y <= region_high.y; ++y)
        for (int x = region_low.x; x <= region_high.x; ++x) {
          const glm::ivec3 region_corner = k_region_samples * glm::ivec3(x, y, z);
          const Region* region = regions_[region_index(region_corner)].get();
          if (region == nullptr) continue;
          for_children(region_corner, k_page_samples, [&](const glm::ivec3& page_corner, std::size_t p) {
            const Page* page = region->pages[p].get();
            if (page == nullptr) return;
            for_children(page_corner, k_brick, [&](const glm::ivec3& brick_corner, std::size_t b) {
              if (page->bricks[b]) each(brick_corner, *page->bricks[b]);
            });
          });
        }
  }
  /// Distance (mm) of a sample to the removed matter, clamped to +-band; +band where nothing was cut or
  /// beyond the lattice.
  double sample_distance(const glm::ivec3& s) const noexcept {
    if (!lattice_.contains(s)) return band_mm_;
    const Brick* brick = brick_at(s);
    return brick ? static_cast<double>(brick->distance[Brick::index(s.x & 7, s.y & 7, s.z & 7)]) : band_mm_;
  }

  /// Returns true if the voxel's centre is not removed (distance > 0). Requires v inside the grid.
  bool is_kept(const glm::ivec3& v) const noexcept {
    const glm::ivec3 s = lattice_.centre_of(v);
    const Brick* brick = brick_at(s);
    return brick == nullptr || brick->is_kept(s.x & 7, s.y & 7, s.z & 7);
  }
  /// Distance (mm) at a voxel's centre, also beyond the grid.
  double voxel_distance(int x, int y, int z) const noexcept {
    return sample_distance(lattice_.centre_of({x, y, z}));
  }
  /// Distance (mm) at p (volume frame), trilinear between samples.
  double distance(const glm::dvec3& p) const noexcept;
  /// Gradient of the trilinear distance, mm per voxel step.
  glm::dvec3 distance_gradient(const glm::dvec3& p) const noexcept;
  /// Returns true if a brick contains any of the eight samples around p (volume frame).
  bool is_near_cut(const glm::dvec3& p) const noexcept;
  /// Returns true if threads other than the edit thread may read masks (removed_share(), content_hash()).
  /// Masks of a version that is not frozen may change until its stroke ends; all other data never change.
  bool is_frozen() const noexcept {
    return !frozen_strokes_ || stroke_ <= frozen_strokes_->load(std::memory_order_acquire);
  }
  /// Returns the removed share of a voxel's cube, 0 to 1, counted in the masks.
  double removed_share(const glm::ivec3& v) const noexcept;
  /// Clears the bits of voxels whose centre is removed. `words`: the words first_word .. first_word + count -
  /// 1 of row (y, z) of the voxels, one bit per voxel, 64 voxels per word.
  void mask_row(int y, int z, int first_word, int count, std::uint64_t* words) const noexcept;

  /// Returns true if mask_row() with these arguments may clear a bit.
  bool has_brick(int y, int z, int first_word, int count) const noexcept;

  /// Hash (FNV-1a over 64-bit words) of the removed matter: distances, kept bits and masks with their base
  /// bits. Equal states have equal hashes.
  std::uint64_t content_hash() const noexcept;

 private:
  friend class RemovalEditor;
  friend class VersionChanges;
  /// Index of a child in a table of 8 x 8 x 8; uses the lowest three bits of each coordinate.
  static std::size_t child_index(int x, int y, int z) noexcept {
    return static_cast<std::size_t>((x & 7) + 8 * ((y & 7) + 8 * (z & 7)));
  }
  std::size_t region_index(const glm::ivec3& s) const noexcept {
    return static_cast<std::size_t>((s.x >> 9) +
                                    regions_size_.x * ((s.y >> 9) + regions_size_.y * (s.z >> 9)));
  }
  static std::size_t page_index(const glm::ivec3& s) noexcept {
    return child_index(s.x >> 6, s.y >> 6, s.z >> 6);
  }
  static std::size_t brick_index(const glm::ivec3& s) noexcept {
    return child_index(s.x >> 3, s.y >> 3, s.z >> 3);
  }
  template <class Each>
  void for_bricks(Each&& each) const;

  std::shared_ptr<const Volume> base_;
  CutLattice lattice_;
  glm::ivec3 regions_size_;
  std::vector<Ref<Region>> regions_;
  Ref<Brick> hollow_;  ///< shared by all hollow slots
  RemovalLedger ledger_;
  /// Last stroke that the editor ended; null: never edited.
  std::shared_ptr<const std::atomic<std::uint64_t>> frozen_strokes_;
  double band_mm_;
  int brick_count_ = 0;
  std::uint64_t serial_ = 0;
  std::uint64_t stroke_ = 0;  ///< last stroke that wrote its masks
};

}  // namespace trephine::volume
