// VoxelGrid, OffsetGrid: grids for methods that touch cubes or surface nets. A point tool touches the voxels
// of a scene. For a round tool, the grid is the lattice of the offset fields, in which the tool's centre
// moves.
#pragma once

#include <algorithm>

#include "haptics/proxy/proxy_step.h"
#include "haptics/scene/touch_state.h"
#include "volume/surface/cell_samples.h"

namespace trephine::haptics {

/// Returns the unit normal (world) of a shape's surface at p (volume frame), out of the solid: of the scan's
/// field, or of the cut if that is nearer. Zero where the field is flat. Adds the number of cells that it
/// reads to `cells`.
glm::dvec3 outward_normal(const TouchItem& shape, const volume::Version& version, const glm::dvec3& p,
                          int& cells) noexcept;

/// The voxels of a scene's base volume, for a point tool. Borrows scene and version. Any thread.
class VoxelGrid {
 public:
  using Samples = volume::VoxelSamples;
  VoxelGrid(const TouchScene& scene, const volume::Version& version) noexcept
      : scene_(scene), version_(version) {}

  const volume::Frame& frame() const noexcept { return version_.base().frame; }
  const glm::ivec3& size() const noexcept { return scene_.base->size; }
  bool contains(const glm::ivec3& v) const noexcept { return scene_.base->contains(v); }
  bool is_solid(std::size_t shape, const glm::ivec3& v) const noexcept {
    return contains(v) && is_solid_within(shape, v);
  }
  /// Tests a voxel that is in the grid.
  bool is_solid_within(std::size_t shape, const glm::ivec3& v) const noexcept {
    return scene_.items[shape].bits->is_solid(v) && version_.is_kept(v);
  }
  /// Returns a box of voxels around v that are free of the shapes `first` to `last` - 1; low > high if a
  /// solid is near. Requires v in the grid.
  volume::VoxelBox empty_box(const glm::ivec3& v, std::size_t first, std::size_t last) const noexcept {
    int far = scene_.items[first].bits->empty_distance(v);
    for (std::size_t s = first + 1; s < last; ++s)
      far = std::min(far, scene_.items[s].bits->empty_distance(v));
    const glm::ivec3 block(v.x >> 2, v.y >> 2, v.z >> 2);
    return {4 * (block - (far - 1)), 4 * (block + far) - 1};
  }
  glm::dvec3 normal(std::size_t shape, const glm::dvec3& p, int& cells) const noexcept {
    return outward_normal(scene_.items[shape], version_, p, cells);
  }
  Samples samples(std::size_t shape) const noexcept {
    const TouchItem& touched = scene_.items[shape];
    return Samples({&touched.field, &version_, touched.bits.get(), false, true});
  }

 private:
  const TouchScene& scene_;
  const volume::Version& version_;
};

/// The lattice of a scene's offset fields, which all shapes of a volume share: solid where the tool's centre
/// must not be. Borrows scene and state. Any thread.
class OffsetGrid {
 public:
  using Samples = volume::OffsetSamples;
  OffsetGrid(const TouchScene& scene, const TouchState& touch_state) noexcept
      : scene_(scene), touch_state_(touch_state) {}

  const volume::Frame& frame() const noexcept { return scene_.items[0].offset->frame(); }
  const glm::ivec3& size() const noexcept { return scene_.items[0].offset->size(); }
  bool contains(const glm::ivec3& v) const noexcept { return scene_.items[0].offset->contains(v); }
  bool is_solid(std::size_t shape, const glm::ivec3& v) const noexcept { return is_solid_within(shape, v); }
  bool is_solid_within(std::size_t shape, const glm::ivec3& v) const noexcept {
    return samples(shape).is_solid(v);
  }
  volume::VoxelBox empty_box(const glm::ivec3& v, std::size_t first, std::size_t last) const noexcept {
    volume::VoxelBox free = touch_state_.offset(scene_, first).free_box(v);
    for (std::size_t s = first + 1; s < last; ++s) {
      const volume::VoxelBox other = touch_state_.offset(scene_, s).free_box(v);
      free = {glm::max(free.low, other.low), glm::min(free.high, other.high)};
    }
    return free;
  }
  glm::dvec3 normal(std::size_t shape, const glm::dvec3& p, int& cells) const noexcept;
  Samples samples(std::size_t shape) const noexcept { return Samples(touch_state_.offset(scene_, shape)); }

 private:
  const TouchScene& scene_;
  const TouchState& touch_state_;
};

/// Runs one step on the grid that the tool touches: `step(grid, state, result)` uses the frame of the grid,
/// and the result is converted to the frame of the volume. If the proxy does not move, or ends at the HIP,
/// the conversion adds no rounding error.
template <class Step>
ProxyStep step_on_grid(const TouchScene& scene, const TouchState& touch_state, ProxyState& state,
                       const ProxyInput& input, Step&& step) noexcept {
  ProxyStep result;
  result.normal_world = glm::dvec3(0);
  if (scene.tool->radius() <= 0 || scene.items.empty()) {
    step(VoxelGrid(scene, *touch_state.version), state, result);
    return result;
  }
  const OffsetGrid grid(scene, touch_state);
  const volume::Frame &lattice = grid.frame(), &base = touch_state.version->base().frame;
  const glm::dvec3 start = state.proxy_volume,
                   start_on_grid = lattice.volume_from_world(base.world_from_volume(start)),
                   hip_on_grid = lattice.volume_from_world(input.hip_world);
  const bool had_proxy = state.has_proxy;
  state.proxy_volume = start_on_grid;
  step(grid, state, result);
  const auto in_volume = [&](const glm::dvec3& p) {
    if (had_proxy && p == start_on_grid) return start;
    return base.volume_from_world(p == hip_on_grid ? input.hip_world : lattice.world_from_volume(p));
  };
  state.proxy_volume = in_volume(state.proxy_volume);
  for (int i = 0; i < result.waypoint_count; ++i) {
    glm::dvec3& p = result.path_volume[static_cast<std::size_t>(i)];
    p = in_volume(p);
  }
  return result;
}

}  // namespace trephine::haptics
