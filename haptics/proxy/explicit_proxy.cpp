#include "haptics/proxy/explicit_proxy.h"

#include "haptics/mesh/god_object.h"
#include "haptics/proxy/friction.h"
#include "haptics/walls/cell_cast.h"
#include "haptics/walls/solid_grid.h"
#include "haptics/walls/union_samples.h"
#include "volume/surface/local_net.h"
#include "volume/surface/marching_cubes.h"

namespace trephine::haptics {

using glm::dvec3;
using glm::ivec3;

namespace {

/// Casts motions against the surfaces of all shapes, in the grid's frame. `Local` makes the triangles of a
/// cell.
template <class Grid, template <class> class Local>
class SurfaceCaster {
 public:
  /// `inside`: shapes whose solid contains the proxy. They are not a part of the union.
  SurfaceCaster(const TouchScene& scene, const Grid& grid, const ShapeSet& passable, const ShapeSet& inside,
                ProxyCounters& counters) noexcept
      : scene_(scene), grid_(grid), passable_(passable), counters_(counters) {
    for (int s = 0; s < static_cast<int>(scene.items.size()); ++s)
      if (blocks(scene, passable, s, Side::front) && !inside.contains(s)) front_.set(s, true), ++front_count_;
  }

  bool operator()(const dvec3& a, const dvec3& b, FacetHit& hit) const noexcept {
    if (a == b) return false;
    bool is_hit = false;
    for (int s = 0; s < static_cast<int>(scene_.items.size()); ++s) is_hit = cast(s, a, b, hit, is_hit);
    return front_count_ > 1 ? cast_on_union(a, b, hit, is_hit) : is_hit;
  }

  /// Returns true if p is behind the surface of the shape.
  bool is_behind(int s, const dvec3& p) const noexcept { return is_behind_cells(surface_of(s), p); }

 private:
  using Surface = Local<typename Grid::Samples>;
  Surface surface_of(int s) const noexcept { return Surface(grid_.samples(static_cast<std::size_t>(s))); }

  /// Casts against one shape. `is_hit`: another shape was met at hit.t, and only a nearer hit counts. Returns
  /// true if any shape was met.
  bool cast(int s, const dvec3& a, const dvec3& b, FacetHit& hit, bool is_hit) const noexcept {
    const bool is_front = blocks(scene_, passable_, s, Side::front),
               is_back = blocks(scene_, passable_, s, Side::back);
    if (!is_front && !is_back) return is_hit;
    const auto shape = static_cast<std::size_t>(s);
    const auto empty_box = [&](const ivec3& cell) {
      return grid_.contains(cell) ? grid_.empty_box(cell, shape, shape + 1)
                                  : volume::VoxelBox{ivec3(1), ivec3(0)};
    };
    const bool is_nearer = cast_on_cells(surface_of(s), grid_.frame(), grid_.size(), empty_box, a, b,
                                         is_front, is_back, is_hit, hit, counters_);
    if (is_nearer) hit.shape = s;
    return is_hit || is_nearer;
  }

  /// Casts against the surface of all shapes that block from the front.
  bool cast_on_union(const dvec3& a, const dvec3& b, FacetHit& hit, bool is_hit) const noexcept {
    const auto samples_of = [this](int s) { return grid_.samples(static_cast<std::size_t>(s)); };
    using Samples = UnionSamples<decltype(samples_of)>;
    const Samples samples(samples_of, front_);
    const auto empty_box = [&](const ivec3& cell) {
      return grid_.contains(cell) ? grid_.empty_box(cell, 0, scene_.items.size())
                                  : volume::VoxelBox{ivec3(1), ivec3(0)};
    };
    if (!cast_on_cells(Local<Samples>(samples), grid_.frame(), grid_.size(), empty_box, a, b, true, false,
                       is_hit, hit, counters_))
      return is_hit;
    hit.shape = samples.owner_near(a + hit.t * (b - a));
    return true;
  }

  const TouchScene& scene_;
  const Grid& grid_;
  const ShapeSet& passable_;
  ProxyCounters& counters_;
  ShapeSet front_;  ///< shapes that block from the front
  int front_count_ = 0;
};

template <template <class> class Local, class Grid>
void step_on_triangles(const TouchScene& scene, const Grid& grid, std::uint64_t serial,
                       const ProxyInput& input, ProxyState& state, ProxyStep& result) noexcept {
  const volume::Frame& frame = grid.frame();
  const dvec3 hip = frame.volume_from_world(input.hip_world);
  const ShapeSet passable = state.around.passable;
  const SurfaceCaster<Grid, Local> caster(scene, grid, passable, state.inside, result.counters);

  // The first step, and any step in which matter has grown over the proxy, starts at the HIP, even inside a
  // solid.
  bool is_fresh = !state.has_proxy;
  if (!is_fresh && state.version != serial)
    for (int s = 0; s < static_cast<int>(scene.items.size()); ++s) {
      const bool was = state.inside.contains(s), is_now = caster.is_behind(s, state.proxy_volume);
      if (was != is_now && blocks(scene, state.around.passable, s, side_of(was)))
        result.is_buried = is_fresh = true;
    }
  if (is_fresh) {
    begin_at_hip(hip, input.hip_world, state, result);
    state.version = serial;
    for (int s = 0; s < static_cast<int>(scene.items.size()); ++s)
      state.inside.set(s, caster.is_behind(s, hip));
    return;
  }

  const glm::dvec3& spacing = frame.spacing();
  const double gap = k_facet_gap * std::min(std::min(spacing.x, spacing.y), spacing.z);
  PathFacets facets;
  const int landing =
      move_god_object(frame, input.hip_world, state.proxy_volume, gap, caster, facets, result);
  const dvec3 before = state.proxy_volume;
  const auto is_blocked = [&](const dvec3& a, const dvec3& b) {
    FacetHit hit;
    return caster(a, b, hit);
  };
  end_with_friction(frame, scene, input.hip_world, landing, &facets, is_blocked, state, result);
  const dvec3& proxy = state.proxy_volume;
  state.version = serial;
  // The proxy enters and leaves a solid only through a side that does not block. Tests this if the proxy
  // moved and was in a solid, or moved without contact.
  if (proxy != before && (!state.inside.is_empty() || !result.has_contact)) {
    for (int s = 0; s < static_cast<int>(scene.items.size()); ++s)
      state.inside.set(s, caster.is_behind(s, proxy));
  }
}

}  // namespace

bool is_behind_triangles(const TouchScene& scene, const TouchState& touch_state, std::size_t shape,
                         const dvec3& position) noexcept {
  ProxyCounters counters;
  const ShapeSet no_shapes;
  const auto is_behind = [&](const auto& grid, const dvec3& p) {
    using Grid = std::decay_t<decltype(grid)>;
    const int s = static_cast<int>(shape);
    return SurfaceCaster<Grid, volume::LocalNet>(scene, grid, no_shapes, no_shapes, counters)
               .is_behind(s, p) ||
           SurfaceCaster<Grid, volume::LocalCubes>(scene, grid, no_shapes, no_shapes, counters)
               .is_behind(s, p);
  };
  if (scene.tool->radius() <= 0) return is_behind(VoxelGrid(scene, *touch_state.version), position);
  const OffsetGrid grid(scene, touch_state);
  return is_behind(
      grid, grid.frame().volume_from_world(touch_state.version->base().frame.world_from_volume(position)));
}

Status ExplicitProxy::prepare(const TouchScene& scene) {
  if (Status error = check_touchable(scene, info())) return error;
  if (scene.smallest_burr <= 0) return std::nullopt;
  // Triangles connect voxels, so that they do not show a hole narrower than the longest edge of a voxel.
  const glm::dvec3& spacing = scene.base->frame.spacing();
  return check_smallest_burr(scene, std::max({spacing.x, spacing.y, spacing.z}));
}

ProxyStep ExplicitProxy::step(const TouchScene& scene, const TouchState& touch_state, ProxyState& state,
                              const ProxyInput& input) const noexcept {
  return step_on_grid(scene, touch_state, state, input,
                      [&](const auto& grid, ProxyState& on_grid, ProxyStep& result) {
                        if (surface_ == Surface::net)
                          step_on_triangles<volume::LocalNet>(scene, grid, touch_state.version->serial(),
                                                              input, on_grid, result);
                        else
                          step_on_triangles<volume::LocalCubes>(scene, grid, touch_state.version->serial(),
                                                                input, on_grid, result);
                      });
}

}  // namespace trephine::haptics
