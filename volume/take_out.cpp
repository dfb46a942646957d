// Removal of whole parts: bone flaps, chips.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/gtc/matrix_access.hpp>
#include <glm/matrix.hpp>

#include "volume/removal.h"

namespace trephine::volume {

/// How far samples are within what goes: half the difference of the distances to the nearest sample that goes
/// and to the nearest that stays, but nowhere more than the band beyond what goes. Like every distance it
/// changes by no more than the way.
class PartingDistances {
 public:
  PartingDistances(const SolidParts& parts, const std::vector<std::uint8_t>& goes, const Version& version)
      : parts_(parts), goes_(goes), band_(version.band_mm()) {
    const Frame& frame = version.lattice().frame();
    const double reach = 2 * band_;
    const glm::dmat3 inverse = glm::inverse(frame.axes());
    for (int a = 0; a < 3; ++a)
      halo_[a] = static_cast<int>(std::ceil(reach * glm::length(glm::row(inverse, a))));
    for (int z = -halo_.z; z <= halo_.z; ++z)
      for (int y = -halo_.y; y <= halo_.y; ++y)
        for (int x = -halo_.x; x <= halo_.x; ++x)
          if (const double mm = glm::length(frame.vector_world_from_volume({x, y, z})); mm <= reach)
            steps_.push_back({{x, y, z}, mm});
    std::sort(steps_.begin(), steps_.end(), [](const Step& a, const Step& b) {
      const auto order = [](const Step& s) {
        return std::array{double(s.by.z), double(s.by.y), double(s.by.x)};
      };
      return a.mm != b.mm ? a.mm < b.mm : order(a) < order(b);
    });
    window_ = k_edge + 2 * halo_;
    state_.resize(static_cast<std::size_t>(window_.x) * static_cast<std::size_t>(window_.y) *
                  static_cast<std::size_t>(window_.z));
    row_.resize(static_cast<std::size_t>(window_.x));
    for (Step& step : steps_)
      step.offset =
          step.by.x + std::ptrdiff_t{window_.x} * (step.by.y + std::ptrdiff_t{window_.y} * step.by.z);
  }
  const glm::ivec3& halo() const noexcept { return halo_; }

  enum class Kind { nothing, some, all };
  /// Finds them for the brick that begins at `low` and the samples around it.
  Kind find(const glm::ivec3& low) {
    const glm::ivec3 first = low - 1 - halo_;
    bool some_go = false, all_go = true;
    std::size_t at = 0;
    for (int z = 0; z < window_.z; ++z)
      for (int y = 0; y < window_.y; ++y) {
        parts_.row(first.x, first.y + y, first.z + z, window_.x, row_.data());
        for (const int part : row_) {
          const std::uint8_t state = part == SolidParts::k_air               ? k_air
                                     : goes_[static_cast<std::size_t>(part)] ? k_goes
                                                                             : k_stays;
          some_go = some_go || state == k_goes;
          all_go = all_go && state == k_goes;
          state_[at++] = state;
        }
      }
    if (!some_go) return Kind::nothing;
    if (all_go) {
      mm_.fill(-static_cast<float>(band_));
      return Kind::all;
    }
    std::size_t i = 0;
    for (int z = 0; z < k_edge; ++z)
      for (int y = 0; y < k_edge; ++y)
        for (int x = 0; x < k_edge; ++x)
          mm_[i++] = static_cast<float>(
              distance_at((halo_.x + x) + std::ptrdiff_t{window_.x} *
                                              ((halo_.y + y) + std::ptrdiff_t{window_.y} * (halo_.z + z))));
    return Kind::some;
  }
  /// mm, of a sample -1 .. 8 along each axis of that brick; negative: goes.
  float at(const glm::ivec3& in) const noexcept {
    return mm_[static_cast<std::size_t>((in.x + 1) + k_edge * ((in.y + 1) + k_edge * (in.z + 1)))];
  }
  /// Which points of a cell go, linear between samples; false: none.
  template <std::size_t Words>
  bool points_within(const glm::ivec3& in, const glm::vec3& shift,
                     std::array<std::uint64_t, Words>& points) const noexcept {
    constexpr int n = Words == 1 ? 4 : 8;
    float least = at(in), most = least;
    for (int i = 0; i < 27; ++i) {
      const float d = at(in + glm::ivec3(i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1));
      least = std::min(least, d), most = std::max(most, d);
    }
    if (least > 0) return false;
    if (most <= 0) {
      points.fill(~std::uint64_t{0});
      return true;
    }
    bool some = false;
    for (int p = 0; p < n * n * n; ++p) {
      const glm::vec3 o =
          (glm::vec3(p % n, p / n % n, p / (n * n)) + 0.5f + shift) / static_cast<float>(n) - 0.5f;
      const glm::ivec3 cell(glm::floor(o));
      const glm::vec3 t = o - glm::vec3(cell);
      const auto along_x = [&](int y, int z) {
        const float a = at(in + cell + glm::ivec3(0, y, z)), b = at(in + cell + glm::ivec3(1, y, z));
        return a + t.x * (b - a);
      };
      const float low = along_x(0, 0) + t.y * (along_x(1, 0) - along_x(0, 0)),
                  high = along_x(0, 1) + t.y * (along_x(1, 1) - along_x(0, 1));
      if (low + t.z * (high - low) > 0) continue;
      points[static_cast<std::size_t>(p) / 64] |= std::uint64_t{1} << (p % 64);
      some = true;
    }
    return some;
  }

 private:
  static constexpr int k_edge = k_brick + 2;  ///< of a brick and the samples around it
  static constexpr std::uint8_t k_air = 0, k_goes = 1, k_stays = 2;
  struct Step {
    glm::ivec3 by;
    double mm;
    std::ptrdiff_t offset = 0;
  };
  double distance_at(std::ptrdiff_t at) const {
    double to_going = 2 * band_, to_staying = 2 * band_;
    unsigned seen = 0;
    for (const Step& step : steps_) {
      const std::uint8_t state = state_[static_cast<std::size_t>(at + step.offset)];
      if ((state & ~seen) == 0) continue;
      (state == k_goes ? to_going : to_staying) = step.mm;
      if ((seen |= state) == (k_goes | k_stays)) break;
    }
    return std::clamp(std::max(0.5 * (to_going - to_staying), to_going - band_), -band_, band_);
  }

  const SolidParts& parts_;
  const std::vector<std::uint8_t>& goes_;
  double band_;
  glm::ivec3 halo_, window_;
  std::vector<Step> steps_;  ///< nearest first
  std::vector<std::uint8_t> state_;
  std::vector<int> row_;
  std::array<float, k_edge * k_edge * k_edge> mm_{};
};

RemovalReport RemovalEditor::take_out(const SolidParts& parts, const std::vector<std::uint8_t>& goes,
                                      const VoxelBox& voxels) {
  RemovalReport report;
  const CutLattice& lattice = next_->lattice_;
  PartingDistances distances(parts, goes, *next_);
  const glm::ivec3 low = glm::max(lattice.low_of(voxels.low) - distances.halo(), glm::ivec3(0)),
                   high = glm::min(lattice.high_of(voxels.high) + distances.halo(), lattice.size() - 1);
  const glm::ivec3 last = next_->base().size - 1;
  report.box = {glm::clamp(lattice.voxel_of(low), glm::ivec3(0), last),
                glm::clamp(lattice.voxel_of(high), glm::ivec3(0), last)};
  for (int z = low.z / k_brick; z <= high.z / k_brick; ++z)
    for (int y = low.y / k_brick; y <= high.y / k_brick; ++y)
      for (int x = low.x / k_brick; x <= high.x / k_brick; ++x)
        take_out_of_brick(distances, k_brick * glm::ivec3(x, y, z), report);
  next_->ledger_.freed_units += report.removed_units;
  return report;
}

/// The points of a brick's cells at which the distances, linear between samples, say that they go.
template <std::size_t Words>
void RemovalEditor::take_points(const PartingDistances& distances, const glm::ivec3& low, RemovalMask& mask,
                                RemovalReport& report) {
  for (int z = 0; z < k_brick; ++z)
    for (int y = 0; y < k_brick; ++y)
      for (int x = 0; x < k_brick; ++x) {
        const std::size_t in_brick = Brick::index(x, y, z);
        if (mask.full[in_brick / 64] >> (in_brick % 64) & 1) continue;
        const glm::ivec3 in(x, y, z), sample = low + in;
        std::array<std::uint64_t, Words> points{};
        if (!distances.points_within(in, point_shift(sample), points)) continue;
        if (mark(mask, in_brick, points) && next_->base().contains(next_->lattice_.voxel_of(sample)))
          report.removed_units += count_solid(mask, sample, in_brick, points.data());
      }
}

void RemovalEditor::take_out_of_brick(PartingDistances& distances, const glm::ivec3& low,
                                      RemovalReport& report) {
  const Brick* old = next_->brick_at(low);
  if (old && old->is_hollow) return;
  const PartingDistances::Kind kind = distances.find(low);
  if (kind == PartingDistances::Kind::nothing) return;
  const auto band = static_cast<float>(next_->band_mm_);
  BrickSweep sweep{};
  for (int z = 0; z < k_brick; ++z)
    for (int y = 0; y < k_brick; ++y)
      for (int x = 0; x < k_brick; ++x) {
        const std::size_t i = Brick::index(x, y, z);
        const float before = old ? old->distance[i] : band;
        sweep.distance[i] = std::min(before, distances.at({x, y, z}));
        sweep.is_nearer = sweep.is_nearer || sweep.distance[i] < before;
        if (sweep.distance[i] > 0) sweep.kept[i / 64] |= std::uint64_t{1} << (i % 64);
      }
  if (!sweep.is_nearer) return;
  Brick& brick = swept_brick(low, sweep);
  ++report.bricks_changed;
  if (!brick.mask) {
    brick.mask = Ref<RemovalMask>(new RemovalMask(4));
    classify(*brick.mask, low);
    brick.mask->stroke = stroke_;
  }
  RemovalMask& mask = editable_mask(brick, 4);
  if (mask.n == 4)
    take_points<1>(distances, low, mask, report);
  else
    take_points<8>(distances, low, mask, report);
  if (kind == PartingDistances::Kind::all) editable_slot(low) = next_->hollow_;
}

}  // namespace trephine::volume
