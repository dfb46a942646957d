// RemovalEditor: removal of a RemovalField, given by distances at samples of the cut lattice.
#include <algorithm>
#include <array>
#include <glm/common.hpp>

#include "volume/cuts/removal.h"
#include "volume/cuts/removal_kernels.h"

namespace trephine::volume {

namespace {

/// Distance (mm) of sample `s`, relative to the first sample of the brick: -1 to 8 along each axis.
float at(const RemovalField::Distances& mm, const glm::ivec3& s) noexcept {
  constexpr int k_edge = RemovalField::k_edge;
  return mm[static_cast<std::size_t>((s.x + 1) + k_edge * ((s.y + 1) + k_edge * (s.z + 1)))];
}

/// Sets the bits of the points of the cell around sample `s` at which the distance (trilinear between
/// samples) is at most 0; returns false if no bit was set. `shift`: point_shift() of the sample.
template <std::size_t Words>
bool points_within(const RemovalField::Distances& mm, const glm::ivec3& s, const glm::vec3& shift,
                   std::array<std::uint64_t, Words>& points) noexcept {
  constexpr int n = Words == 1 ? 4 : 8;
  float lowest = at(mm, s), highest = lowest;
  for (int i = 0; i < 27; ++i) {
    const float d = at(mm, s + glm::ivec3(i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1));
    lowest = std::min(lowest, d), highest = std::max(highest, d);
  }
  if (lowest > 0) return false;
  if (highest <= 0) {
    points.fill(~std::uint64_t{0});
    return true;
  }
  bool has_points = false;
  for (int p = 0; p < n * n * n; ++p) {
    const glm::vec3 o =
        (glm::vec3(p % n, p / n % n, p / (n * n)) + 0.5f + shift) / static_cast<float>(n) - 0.5f;
    const glm::ivec3 cell(glm::floor(o));
    const glm::vec3 t = o - glm::vec3(cell);
    const auto along_x = [&](int y, int z) {
      const float a = at(mm, s + cell + glm::ivec3(0, y, z)), b = at(mm, s + cell + glm::ivec3(1, y, z));
      return a + t.x * (b - a);
    };
    const float low = along_x(0, 0) + t.y * (along_x(1, 0) - along_x(0, 0)),
                high = along_x(0, 1) + t.y * (along_x(1, 1) - along_x(0, 1));
    if (low + t.z * (high - low) > 0) continue;
    points[static_cast<std::size_t>(p) / 64] |= std::uint64_t{1} << (p % 64);
    has_points = true;
  }
  return has_points;
}

}  // namespace

RemovalReport RemovalEditor::remove(RemovalField& field, const VoxelBox& samples, Ledger ledger) {
  RemovalReport report;
  const CutLattice& lattice = next_->lattice_;
  const glm::ivec3 low = glm::max(samples.low, glm::ivec3(0)),
                   high = glm::min(samples.high, lattice.size() - 1);
  const glm::ivec3 last = next_->base().size - 1;
  report.box = {glm::clamp(lattice.voxel_of(low), glm::ivec3(0), last),
                glm::clamp(lattice.voxel_of(high), glm::ivec3(0), last)};
  for (int z = low.z / k_brick; z <= high.z / k_brick; ++z)
    for (int y = low.y / k_brick; y <= high.y / k_brick; ++y)
      for (int x = low.x / k_brick; x <= high.x / k_brick; ++x)
        remove_in_brick(field, k_brick * glm::ivec3(x, y, z), ledger, report);
  if (ledger == Ledger::freed) next_->ledger_.detached_units += report.removed_units;
  return report;
}

void RemovalEditor::remove_in_brick(RemovalField& field, const glm::ivec3& low, Ledger ledger,
                                    RemovalReport& report) {
  const Brick* old = next_->brick_at(low);
  if (old && old->is_hollow) return;
  RemovalField::Distances mm;
  const RemovalField::Reach reach = field.find(low, next_->band_mm_, mm);
  if (reach == RemovalField::Reach::none) return;
  const auto band = static_cast<float>(next_->band_mm_);
  BrickSweep sweep{};
  for (int z = 0; z < k_brick; ++z)
    for (int y = 0; y < k_brick; ++y)
      for (int x = 0; x < k_brick; ++x) {
        const std::size_t i = Brick::index(x, y, z);
        const float before = old ? old->distance[i] : band;
        sweep.distance[i] = std::min(before, at(mm, {x, y, z}));
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
    mark_points<1>(mm, low, mask, ledger, report);
  else
    mark_points<8>(mm, low, mask, ledger, report);
  if (reach == RemovalField::Reach::all) editable_slot(low) = next_->hollow_;
}

/// Marks and counts the points of a brick's cells at which the distance (trilinear between samples) is at
/// most 0.
template <std::size_t Words>
void RemovalEditor::mark_points(const RemovalField::Distances& mm, const glm::ivec3& low, RemovalMask& mask,
                                Ledger ledger, RemovalReport& report) {
  for (int z = 0; z < k_brick; ++z)
    for (int y = 0; y < k_brick; ++y)
      for (int x = 0; x < k_brick; ++x) {
        const std::size_t in_brick = Brick::index(x, y, z);
        if (mask.full[in_brick / 64] >> (in_brick % 64) & 1) continue;
        const glm::ivec3 offset(x, y, z), sample = low + offset;
        std::array<std::uint64_t, Words> points{};
        // Removed air is not counted. So all points of a cell of air are marked, or no point.
        if (mask.base_air[in_brick / 64] >> (in_brick % 64) & 1) {
          points.fill(at(mm, offset) <= 0 ? ~std::uint64_t{0} : 0);
          mark(mask, in_brick, points);
          continue;
        }
        if (!points_within(mm, offset, point_shift(sample), points)) continue;
        if (mark(mask, in_brick, points) && next_->base().contains(next_->lattice_.voxel_of(sample)))
          count(mask, sample, in_brick, points.data(), ledger, report);
      }
}

}  // namespace trephine::volume
