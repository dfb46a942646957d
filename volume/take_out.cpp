// Removal of whole parts: bone flaps, chips.
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/gtc/matrix_access.hpp>
#include <glm/matrix.hpp>

#include "volume/removal.h"

namespace trephine::volume {

namespace {

/// Depth of samples within what goes: half the difference of the distances to the nearest sample that goes
/// and to the nearest that stays, but nowhere more than the band beyond what goes. Like every distance it
/// changes by no more than the way.
class PartingDistances final : public RemovalField {
 public:
  PartingDistances(const SolidParts& parts, const std::vector<std::uint8_t>& goes, const Version& version)
      : parts_(parts), goes_(goes), band_(version.band_mm()) {
    const Frame& frame = version.lattice().frame();
    const double reach = 2 * band_;
    const glm::dmat3 inverse = glm::inverse(frame.axes());
    for (int a = 0; a < 3; ++a)
      halo_[a] = static_cast<int>(std::ceil(reach * glm::length(glm::row(inverse, a))));
    // A row is a word. Where voxels are so much finer along x it looks less far that way, which changes no
    // sign.
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
    going_.resize(rows), staying_.resize(rows);
    parts_of_row_.resize(static_cast<std::size_t>(window_.x));
  }
  const glm::ivec3& halo() const noexcept { return halo_; }

  Reach find(const glm::ivec3& low, double, Distances& mm) override {
    const glm::ivec3 first = low - 1 - halo_;
    const std::uint64_t whole = ~std::uint64_t{0} >> (64 - window_.x);
    std::uint64_t any_goes = 0, any_stays = 0, all_go = whole;
    std::size_t at = 0;
    for (int z = 0; z < window_.z; ++z)
      for (int y = 0; y < window_.y; ++y, ++at) {
        parts_.row(first.x, first.y + y, first.z + z, window_.x, parts_of_row_.data());
        going_[at] = staying_[at] = 0;
        for (std::size_t x = 0; x < parts_of_row_.size(); ++x)
          if (const int part = parts_of_row_[x]; part != SolidParts::k_air)
            (goes_[static_cast<std::size_t>(part)] ? going_ : staying_)[at] |= std::uint64_t{1} << x;
        any_goes |= going_[at], any_stays |= staying_[at];
        all_go &= going_[at];
      }
    if (any_goes == 0) return Reach::none;
    if (all_go == whole) {
      mm.fill(-static_cast<float>(band_));
      return Reach::all;
    }
    std::size_t i = 0;
    for (int z = 0; z < k_edge; ++z)
      for (int y = 0; y < k_edge; ++y)
        for (int x = 0; x < k_edge; ++x) mm[i++] = static_cast<float>(distance_at({x, y, z}, any_stays != 0));
    return Reach::some;
  }

 private:
  /// Steps to samples along x, at one step along y and z.
  struct Row {
    int y, z;
    double nearest;          ///< mm, the shortest of those
    std::uint64_t bits;      ///< that are within reach, from -halo on
    std::vector<double> mm;  ///< of each
  };
  double distance_at(const glm::ivec3& in, bool is_any_staying) const {
    double to_going = 2 * band_, to_staying = 2 * band_;
    for (const Row& row : rows_) {
      if (row.nearest >= to_going && (!is_any_staying || row.nearest >= to_staying)) break;
      const auto at =
          static_cast<std::size_t>((halo_.y + in.y + row.y) + window_.y * (halo_.z + in.z + row.z));
      const auto look = [&](std::uint64_t window, double& nearest) {
        if (row.nearest >= nearest) return;
        for (std::uint64_t left = window >> in.x & row.bits; left != 0; left &= left - 1)
          nearest = std::min(nearest, row.mm[static_cast<std::size_t>(std::countr_zero(left))]);
      };
      look(going_[at], to_going);
      look(staying_[at], to_staying);
    }
    return std::clamp(std::max(0.5 * (to_going - to_staying), to_going - band_), -band_, band_);
  }

  const SolidParts& parts_;
  const std::vector<std::uint8_t>& goes_;
  double band_;
  glm::ivec3 halo_, window_;
  std::vector<Row> rows_;                       ///< nearest first
  std::vector<std::uint64_t> going_, staying_;  ///< rows of the window
  std::vector<int> parts_of_row_;
};

}  // namespace

RemovalReport RemovalEditor::take_out(const SolidParts& parts, const std::vector<std::uint8_t>& goes,
                                      const VoxelBox& voxels) {
  const CutLattice& lattice = next_->lattice_;
  PartingDistances distances(parts, goes, *next_);
  return remove(
      distances,
      {lattice.low_of(voxels.low) - distances.halo(), lattice.high_of(voxels.high) + distances.halo()},
      Ledger::freed);
}

}  // namespace trephine::volume
