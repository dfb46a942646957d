#include "haptics/explicit_proxy.h"

#include "haptics/friction.h"
#include "haptics/god_object.h"
#include "volume/local_net.h"

namespace trephine::haptics {

using glm::dvec3;
using glm::ivec3;

namespace {

/// Casts ways against the nets of all shapes.
class NetCaster {
 public:
  NetCaster(const TouchScene& scene, const volume::Version& version, const ShapeSet& let_through,
            ProxyCounters& counters) noexcept
      : scene_(scene),
        version_(version),
        let_through_(let_through),
        frame_(version.base().frame),
        counters_(counters) {}

  bool operator()(const dvec3& a, const dvec3& b, FacetHit& hit) const noexcept {
    if (a == b) return false;
    bool is_hit = false;
    for (int s = 0; s < static_cast<int>(scene_.shapes.size()); ++s) is_hit = cast(s, a, b, hit, is_hit);
    return is_hit;
  }

  /// Does p lie behind the net of the shape? By the first triangle on the way to a free corner of its cell.
  bool is_behind(int s, const dvec3& p) const noexcept {
    const volume::LocalNet net = net_of(s);
    ivec3 cell;
    for (int a = 0; a < 3; ++a) cell[a] = static_cast<int>(std::floor(p[a]));
    const int bits = net.config(cell);
    if (bits == 0 || bits == 255) return bits == 255;
    int corner = 0;
    while (bits >> corner & 1) ++corner;
    const dvec3 way = dvec3(cell + ivec3(corner & 1, corner >> 1 & 1, corner >> 2 & 1)) - p;
    double nearest = 2, nearest_facing = 0;
    net.quads_of_cell(cell, [&](const volume::NetQuad& quad) {
      for (const auto& [i, j, k] : k_triangles) {
        double t = 0, facing = 0;
        if (crosses_triangle(p, way, dvec3(quad.corners[i]), dvec3(quad.corners[j]), dvec3(quad.corners[k]),
                             t, facing) &&
            t < nearest)
          nearest = t, nearest_facing = facing;
      }
    });
    return nearest <= 1 && nearest_facing > 0;
  }

 private:
  struct Corners {
    std::size_t i, j, k;
  };
  static constexpr Corners k_triangles[2] = {{0, 1, 2}, {0, 2, 3}};

  volume::LocalNet net_of(int s) const noexcept {
    const TouchShape& shape = scene_.shapes[static_cast<std::size_t>(s)];
    return volume::LocalNet({&shape.field, &version_, shape.bits.get()});
  }

  /// `is_hit`: another shape was met at hit.t; only what is nearer counts.
  bool cast(int s, const dvec3& a, const dvec3& b, FacetHit& hit, bool is_hit) const noexcept {
    const TouchShape& shape = scene_.shapes[static_cast<std::size_t>(s)];
    const bool is_front = holds(scene_, let_through_, s, Sides::front),
               is_back = holds(scene_, let_through_, s, Sides::back);
    if (!is_front && !is_back) return is_hit;
    const volume::LocalNet net = net_of(s);
    const dvec3 way = b - a;
    // Cells are cubes between voxel centres: the traversal's voxels, moved by half a step.
    const volume::VoxelBox box{ivec3(-1), scene_.base->size - 1};
    volume::VoxelWalk walk(volume::Segment(a - 0.5, b - 0.5), box);
    while (!walk.is_done()) {
      const ivec3& cell = walk.voxel();
      ++counters_.cells;
      // A quad reaches beyond its cell: what was hit behind this cell may have something before it in the
      // next.
      if (is_hit && hit.t < walk.t_enter()) return true;
      if (scene_.base->contains(cell)) {
        // The cell's far corners lie one voxel on: two empty blocks away nothing can be met.
        if (const int far = shape.bits->empty_distance(cell); far > 1) {
          const ivec3 block(cell.x >> 2, cell.y >> 2, cell.z >> 2);
          walk.advance_past({4 * (block - (far - 2)), 4 * (block + (far - 1)) - 1});
          continue;
        }
      }
      net.quads_of_cell(cell, [&](const volume::NetQuad& quad) {
        counters_.triangles += 2;
        for (const auto& [i, j, k] : k_triangles) {
          const dvec3 p(quad.corners[i]), q(quad.corners[j]), r(quad.corners[k]);
          double t = 0, facing = 0;
          if (!crosses_triangle(a, way, p, q, r, t, facing) || (is_hit && t >= hit.t)) continue;
          // Triangles look to the free side where the frame is right-handed.
          const bool is_from_free = facing < 0;
          if (is_from_free ? !is_front : !is_back) continue;
          const dvec3 normal = glm::normalize(frame_.gradient_world_from_volume(glm::cross(q - p, r - p)));
          hit = {t, is_from_free ? normal : -normal, s, is_from_free ? 1 : -1};
          is_hit = true;
        }
      });
      walk.advance();
    }
    return is_hit;
  }

  const TouchScene& scene_;
  const volume::Version& version_;
  const ShapeSet& let_through_;
  const volume::Frame& frame_;
  ProxyCounters& counters_;
};

}  // namespace

volume::Status ExplicitProxy::prepare(const TouchScene& scene) { return check_touchable(scene); }

ProxyStep ExplicitProxy::step(const TouchScene& scene, const volume::Version& version, ProxyState& state,
                              const ProxyInput& input) const noexcept {
  const volume::Frame& frame = version.base().frame;
  const dvec3 hip = frame.volume_from_world(input.hip_world);
  ProxyStep result;
  result.normal_world = dvec3(0);
  const NetCaster caster(scene, version, state.around.let_through, result.counters);

  // The first step, and a proxy over which matter has grown, start at the HIP, inside whatever is there.
  bool is_fresh = !state.has_proxy;
  if (!is_fresh && state.version != version.serial())
    for (int s = 0; s < static_cast<int>(scene.shapes.size()); ++s) {
      const bool was = state.inside.contains(s), is_now = caster.is_behind(s, state.proxy_volume);
      if (was != is_now && holds(scene, state.around.let_through, s, side_of(was)))
        result.is_buried = is_fresh = true;
    }
  if (is_fresh) {
    state.begin_at(hip);
    state.version = version.serial();
    for (int s = 0; s < static_cast<int>(scene.shapes.size()); ++s)
      state.inside.set(s, caster.is_behind(s, hip));
    result.proxy_world = input.hip_world;
    result.path_volume[0] = hip;
    result.waypoint_count = 1;
    return result;
  }

  const glm::dvec3& spacing = frame.spacing();
  const double gap = k_facet_gap * std::min(std::min(spacing.x, spacing.y), spacing.z);
  const int landing = move_god_object(frame, input.hip_world, state.proxy_volume, gap, caster, result);
  const dvec3 before = state.proxy_volume;
  const auto is_blocked = [&](const dvec3& a, const dvec3& b) {
    FacetHit hit;
    return caster(a, b, hit);
  };
  end_with_friction(frame, scene, input.hip_world, landing, is_blocked, state, result);
  const dvec3& proxy = state.proxy_volume;
  state.version = version.serial();
  // Inside only where a side does not hold; looked at when the proxy moved without contact.
  if (proxy != before && (!state.inside.is_empty() || !result.has_contact)) {
    for (int s = 0; s < static_cast<int>(scene.shapes.size()); ++s)
      state.inside.set(s, caster.is_behind(s, proxy));
  }
  return result;
}

}  // namespace trephine::haptics
