// RemovalEditor: removal of whole detached parts, such as bone flaps and chips.
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/gtc/matrix_access.hpp>
#include <glm/matrix.hpp>

#include "volume/cuts/removal.h"
#include "volume/cuts/solid_parts.h"

namespace trephine::volume {

namespace {

/// Signed distances to the removed parts: half the difference between the distances to the nearest sample of
/// a removed part and to the nearest sample of a kept part. Positive if all samples of removed parts are
/// farther than the band. Lipschitz continuous with constant 1, as every distance field.
class SeparationDistances final : public RemovalField {
 public:
  SeparationDistances(const SolidParts& parts, const std::vector<std::uint8_t>& is_removed,
                      const Version& version)
      : parts_(parts), is_removed_(is_removed), band_(version.band_mm()) {
    const Frame& frame = version.lattice().frame();
    const double reach = 2 * band_;
    const glm::dmat3 inverse = glm::inverse(frame.axes());
    for (int a = 0; a < 3; ++a)
      halo_[a] = static_cast<int>(std::ceil(reach * glm::length(glm::row(inverse, a))));
    // A row of the window must fit in a word of 64 bits. This shortens the search along x only on a lattice
    // that is much finer along x than along another axis.
    halo_.x = std::min(halo_.x, (64 - k_edge) / 2);
    for (int z = -halo_.z; z <= halo_.z; ++z)
      for (int y = -halo_.y; y <= halo_.y; ++y) {
        Row row{y, z, reach, 0, {}};
        for (int x = -halo_.x; x <= halo_.x; ++x) {
          const double mm = glm::length(frame.vector_world_from_volume({x, y, z}));
          row.mm.push_back(mm);
          if (mm > reach) continue;
          row.nearest = std::min(row.nearest, mm);
          row.bits |= std::uint64_t{1} << (halo_.x + x);
        }
        if (row.bits != 0) rows_.push_back(std::move(row));
      }
    std::sort(rows_.begin(), rows_.end(), [](const Row& a, const Row& b) {
      const auto order = [](const Row& r) { return std::array{r.nearest, double(r.z), double(r.y)}; };
      return order(a) < order(b);
    });
    window_ = k_edge + 2 * halo_;
    TREPHINE_ASSERT(window_.x <= 64);
    const auto rows = static_cast<std::size_t>(window_.y) * static_cast<std::size_t>(window_.z);
    removed_.resize(rows), kept_.resize(rows);
    parts_of_row_.resize(static_cast<std::size_t>(window_.x));
  }
  const glm::ivec3& halo() const noexcept { return halo_; }

  Reach find(const glm::ivec3& low, double, Distances& mm) override {
    const glm::ivec3 first = low - 1 - halo_;
    const std::uint64_t whole = ~std::uint64_t{0} >> (64 - window_.x);
    std::uint64_t any_removed = 0, any_kept = 0, all_removed = whole;
    std::size_t at = 0;
    for (int z = 0; z < window_.z; ++z)
      for (int y = 0; y < window_.y; ++y, ++at) {
        parts_.row(first.x, first.y + y, first.z + z, window_.x, parts_of_row_.data());
        removed_[at] = kept_[at] = 0;
        for (std::size_t x = 0; x < parts_of_row_.size(); ++x)
          if (const int part = parts_of_row_[x]; part != SolidParts::k_air)
            (is_removed_[static_cast<std::size_t>(part)] ? removed_ : kept_)[at] |= std::uint64_t{1} << x;
        any_removed |= removed_[at], any_kept |= kept_[at];
        all_removed &= removed_[at];
      }
    if (any_removed == 0) return Reach::none;
    if (all_removed == whole) {
      mm.fill(-static_cast<float>(band_));
      return Reach::all;
    }
    std::size_t i = 0;
    for (int z = 0; z < k_edge; ++z)
      for (int y = 0; y < k_edge; ++y)
        for (int x = 0; x < k_edge; ++x) mm[i++] = static_cast<float>(distance_at({x, y, z}, any_kept != 0));
    return Reach::some;
  }

 private:
  /// A row of offsets along x, at fixed offsets along y and z.
  struct Row {
    int y, z;
    double nearest;          ///< length of the shortest offset, mm
    std::uint64_t bits;      ///< set for offsets within reach; bit 0: x = -halo
    std::vector<double> mm;  ///< length of each offset, by bit
  };
  double distance_at(const glm::ivec3& s, bool is_any_kept) const {
    double to_removed = 2 * band_, to_kept = 2 * band_;
    for (const Row& row : rows_) {
      if (row.nearest >= to_removed && (!is_any_kept || row.nearest >= to_kept)) break;
      const auto at = static_cast<std::size_t>((halo_.y + s.y + row.y) + window_.y * (halo_.z + s.z + row.z));
      const auto update = [&](std::uint64_t window, double& nearest) {
        if (row.nearest >= nearest) return;
        for (std::uint64_t remaining = window >> s.x & row.bits; remaining != 0; remaining &= remaining - 1)
          nearest = std::min(nearest, row.mm[static_cast<std::size_t>(std::countr_zero(remaining))]);
      };
      update(removed_[at], to_removed);
      update(kept_[at], to_kept);
    }
    return std::clamp(std::max(0.5 * (to_removed - to_kept), to_removed - band_), -band_, band_);
  }

  const SolidParts& parts_;
  const std::vector<std::uint8_t>& is_removed_;
  double band_;
  glm::ivec3 halo_, window_;
  std::vector<Row> rows_;  ///< nearest first
  /// Bits of the samples of removed and of kept parts, one word per row of the window.
  std::vector<std::uint64_t> removed_, kept_;
  std::vector<int> parts_of_row_;
};

}  // namespace

RemovalReport RemovalEditor::remove_parts(const SolidParts& parts,
                                          const std::vector<std::uint8_t>& is_removed,
                                          const VoxelBox& voxels) {
  const CutLattice& lattice = next_->lattice_;
  SeparationDistances distances(parts, is_removed, *next_);
  return remove(
      distances,
      {lattice.low_of(voxels.low) - distances.halo(), lattice.high_of(voxels.high) + distances.halo()},
      Ledger::freed);
}

}  // namespace trephine::volume
