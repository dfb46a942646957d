#include "modules/fluoroscopy/removed_matter.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "volume/base/parallel.h"

namespace trephine::fluoroscopy {

using glm::ivec3;
using volume::Version;

namespace {

/// Adds the blocks of voxels with samples in those bricks of `version` that `other` does not share.
void add_changed(const Version& version, const Version* other, std::set<std::array<int, 3>>& changed) {
  const volume::CutLattice& lattice = version.lattice();
  version.for_bricks_in(ivec3(0), lattice.size() - 1, [&](const ivec3& low, const volume::Brick& brick) {
    if (other != nullptr && other->brick_at(low) == &brick) return;
    const ivec3 first = glm::max(lattice.voxel_of(low), ivec3(0)) / RemovedMatter::k_edge,
                last = glm::min(lattice.voxel_of(low + volume::k_brick - 1), version.base().size - 1);
    if (last.x < 0 || last.y < 0 || last.z < 0) return;
    for (int z = first.z; z <= last.z / RemovedMatter::k_edge; ++z)
      for (int y = first.y; y <= last.y / RemovedMatter::k_edge; ++y)
        for (int x = first.x; x <= last.x / RemovedMatter::k_edge; ++x) changed.insert({z, y, x});
  });
}

/// Returns the removed share of a voxel, computed from the distances of its samples to the cut. The distances
/// of a version are constant, whereas the masks of an unfrozen version still change. A sample closer to the
/// cut than half of `softness` (mm) counts in part.
double removed_share(const Version& version, const ivec3& voxel, double softness) {
  const volume::CutLattice& lattice = version.lattice();
  const ivec3 low = lattice.low_of(voxel), high = lattice.high_of(voxel);
  double sum = 0;
  for (int z = low.z; z <= high.z; ++z)
    for (int y = low.y; y <= high.y; ++y)
      for (int x = low.x; x <= high.x; ++x)
        sum += std::clamp(0.5 - version.sample_distance({x, y, z}) / softness, 0.0, 1.0);
  const ivec3 per = lattice.per_voxel();
  return sum / (static_cast<double>(per.x) * per.y * per.z);
}

}  // namespace

bool has_soft_tissue(const volume::Volume& scan) {
  constexpr std::int16_t k_low = -150, k_bone = 120;  // HU
  const std::size_t stride = 1 + scan.voxels.size() / 400'000;
  std::int64_t tissue = 0, bone = 0;
  for (std::size_t i = 0; i < scan.voxels.size(); i += stride)
    (scan.voxels[i] >= k_bone ? bone : tissue) += scan.voxels[i] >= k_low;
  return tissue > bone;
}

volume::VoxelBox RemovedMatter::box_of(const std::array<int, 3>& position) noexcept {
  const ivec3 low = k_edge * ivec3(position[2], position[1], position[0]);
  return {low, low + k_edge - 1};
}

double RemovedMatter::sum(const volume::Ray& ray, double from, double to, const std::array<int, 3>& position,
                          const Block& block) noexcept {
  return volume::sum_along(ray, from, to, box_of(position), [&block](const ivec3& v) {
    return static_cast<double>(
        block.weights[static_cast<std::size_t>((v.x & 7) + 8 * ((v.y & 7) + 8 * (v.z & 7)))]);
  });
}

double RemovedMatter::interpolated_sum(const volume::Ray& ray, int axis, const std::array<int, 3>& position,
                                       const Block& block) noexcept {
  const glm::dvec3 along = ray.end - ray.start;
  if (along[axis] == 0) return 0;
  const int a = axis == 0 ? 1 : 0, b = axis == 2 ? 1 : 2;
  const ivec3 low = box_of(position).low;
  const auto tent = [](double p) { return std::max(0.0, 1 - std::abs(p)); };
  double sum = 0;
  for (int k = 0; k < k_edge; ++k) {
    const double t = (low[axis] + k - ray.start[axis]) / along[axis];
    if (!(t >= 0 && t <= 1)) continue;
    const glm::dvec3 p = ray.start + t * along - glm::dvec3(low);
    if (!(p[a] > -1 && p[b] > -1 && p[a] < k_edge && p[b] < k_edge)) continue;
    for (int corner = 0; corner < 4; ++corner) {
      ivec3 v;
      v[axis] = k, v[a] = static_cast<int>(std::floor(p[a])) + (corner & 1);
      v[b] = static_cast<int>(std::floor(p[b])) + (corner >> 1);
      if (v[a] < 0 || v[b] < 0 || v[a] >= k_edge || v[b] >= k_edge) continue;
      sum += tent(p[a] - v[a]) * tent(p[b] - v[b]) *
             static_cast<double>(block.weights[static_cast<std::size_t>(v.x + 8 * (v.y + 8 * v.z))]);
    }
  }
  return sum / std::abs(along[axis]);
}

std::vector<ivec3> RemovedMatter::update(const volume::LineIntegrals& lines,
                                         std::shared_ptr<const Version> version, int threads) {
  std::set<std::array<int, 3>> changed;
  add_changed(*version, version_.get(), changed);
  if (version_) add_changed(*version_, version.get(), changed);
  const std::vector<std::array<int, 3>> block_positions(changed.begin(), changed.end());
  std::vector<Block> output(block_positions.size());
  std::vector<std::uint8_t> is_touched(block_positions.size(), 0);
  const volume::Volume& base = version->base();
  const volume::CutLattice& lattice = version->lattice();
  if (fill_attenuation_ < 0) fill_attenuation_ = has_soft_tissue(base) ? lines.weights().of(0) : 0;
  const double softness =
      (lattice.frame().spacing().x + lattice.frame().spacing().y + lattice.frame().spacing().z) / 3;
  parallel_for(static_cast<int>(block_positions.size()), threads, [&](int n) {
    const auto i = static_cast<std::size_t>(n);
    const volume::VoxelBox box = box_of(block_positions[i]);
    const ivec3 last = glm::min(box.high, base.size - 1);
    for (int z = box.low.z; z <= last.z; ++z)
      for (int y = box.low.y; y <= last.y; ++y) {
        if (!version->has_brick(lattice.low_of({box.low.x, y, z}), lattice.high_of({last.x, y, z}))) continue;
        for (int x = box.low.x; x <= last.x; ++x) {
          const std::int16_t intensity = base.voxels[base.index(x, y, z)];
          if (intensity <= lines.weights().highest_weightless) continue;
          const double share = removed_share(*version, {x, y, z}, softness);
          if (!(share > 0)) continue;
          const double decrease = lines.weights().of(intensity) - fill_attenuation_;
          if (!(decrease > 0)) continue;
          output[i].weights[static_cast<std::size_t>((x & 7) + 8 * ((y & 7) + 8 * (z & 7)))] =
              static_cast<float>(share * decrease);
          is_touched[i] = 1;
        }
      }
  });
  std::vector<ivec3> result;
  for (std::size_t i = 0; i < block_positions.size(); ++i) {
    const auto existing = blocks_.find(block_positions[i]);
    if (is_touched[i]) {
      if (existing != blocks_.end() && existing->second.weights == output[i].weights) continue;
      blocks_[block_positions[i]] = output[i];
    } else {
      if (existing == blocks_.end()) continue;
      blocks_.erase(existing);
    }
    result.push_back({block_positions[i][2], block_positions[i][1], block_positions[i][0]});
  }
  version_ = std::move(version);
  return result;
}

}  // namespace trephine::fluoroscopy
