// TracedVoxels: a cut by single lines of voxels, for comparison with the kerf.
#pragma once

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vector_relational.hpp>
#include <set>
#include <tuple>
#include <vector>

#include "modules/bone_flap/kerf.h"
#include "volume/scan/traversal.h"

namespace trephine::bone_flap {

/// Removes all voxels on lines from the apex to points of the outline, and 0.5 mm beyond (Jiang, dissertation
/// "A Surface-based Volume Haptics Approach", section 5.2.3). Such a cut leaves bone between its lines.
class TracedVoxels final : public volume::RemovalField {
 public:
  /// `step`: largest distance between neighbouring points of the outline, mm.
  TracedVoxels(const CutSurface& surface, const volume::Version& version, double step)
      : lattice_(version.lattice()) {
    const volume::Volume& scan = version.base();
    const glm::dvec3 apex = scan.frame.volume_from_world(surface.pyramid().apex_world);
    std::set<std::tuple<int, int, int>> traced;
    const std::size_t n = surface.lines().size();
    for (std::size_t i = 0; i < n; ++i) {
      const glm::dvec3 a = surface.outer_point(i), b = surface.outer_point((i + 1) % n);
      const int count = std::max(1, static_cast<int>(std::ceil(glm::length(b - a) / step)));
      for (int k = 0; k < count; ++k) {
        const glm::dvec3 p = a + static_cast<double>(k) / count * (b - a),
                         end = p + 0.5 * glm::normalize(p - surface.pyramid().apex_world);
        const volume::Segment segment(apex, scan.frame.volume_from_world(end));
        for (volume::VoxelWalk walk(segment, {glm::ivec3(0), scan.size - 1}); !walk.is_done();
             walk.advance()) {
          const glm::ivec3 v = walk.visit().voxel;
          traced.insert({v.z, v.y, v.x});
        }
      }
    }
    const glm::dvec3 half = 0.5 * glm::dvec3(lattice_.per_voxel());
    const glm::dvec3 margin = half + version.band_mm() / lattice_.frame().spacing() + 1.0;
    box_ = {lattice_.size(), glm::ivec3(-1)};
    for (const auto& [z, y, x] : traced) {
      const glm::dvec3 centre(lattice_.centre_of({x, y, z}));
      centres_.push_back(centre);
      box_.low = glm::min(box_.low, glm::ivec3(glm::floor(centre - margin)));
      box_.high = glm::max(box_.high, glm::ivec3(glm::ceil(centre + margin)));
    }
    box_.low = glm::max(box_.low, glm::ivec3(0));
    box_.high = glm::min(box_.high, lattice_.size() - 1);
    margin_ = margin;
  }

  Reach find(const glm::ivec3& low, double band, Distances& mm) override {
    const glm::dvec3 first = glm::dvec3(low - 1) - margin_,
                     last = glm::dvec3(low + volume::k_brick) + margin_;
    std::vector<glm::dvec3> near;
    for (const glm::dvec3& centre : centres_)
      if (glm::all(glm::greaterThanEqual(centre, first)) && glm::all(glm::lessThanEqual(centre, last)))
        near.push_back(centre);
    if (near.empty()) return Reach::none;
    const volume::Frame& frame = lattice_.frame();
    const glm::dvec3 half = 0.5 * glm::dvec3(lattice_.per_voxel());
    bool is_any = false;
    std::size_t sample = 0;
    for (int z = -1; z <= volume::k_brick; ++z)
      for (int y = -1; y <= volume::k_brick; ++y)
        for (int x = -1; x <= volume::k_brick; ++x, ++sample) {
          const glm::dvec3 s(low + glm::ivec3(x, y, z));
          double nearest = band;
          for (const glm::dvec3& centre : near) {
            const glm::dvec3 excess = glm::abs(s - centre) - half, inside = excess * frame.spacing();
            const double depth = std::max({inside.x, inside.y, inside.z});
            const glm::dvec3 outside = frame.vector_world_from_volume(glm::max(excess, glm::dvec3(0.0)));
            nearest = std::min(nearest, depth < 0 ? depth : glm::length(outside));
          }
          mm[sample] = static_cast<float>(std::max(nearest, -band));
          is_any = is_any || nearest < band;
        }
    return is_any ? Reach::some : Reach::none;
  }
  const volume::VoxelBox& samples() const noexcept { return box_; }

 private:
  const volume::CutLattice lattice_;
  std::vector<glm::dvec3> centres_;  ///< of the removed voxels, lattice frame
  glm::dvec3 margin_{0.0};
  volume::VoxelBox box_;
};

}  // namespace trephine::bone_flap
