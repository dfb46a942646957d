#include "haptics/baselines/path_proxy.h"

#include <algorithm>
#include <glm/geometric.hpp>

#include "haptics/walls/barrier.h"

namespace trephine::haptics::baselines {

using glm::dvec3;
using glm::ivec3;

namespace {

constexpr int k_max_nodes = 192;      // voxels that a search may open
constexpr int k_max_idle = 24;        // voxels closed in a row without progress, after which the search ends
constexpr int k_max_length = 24;      // voxels: the longest path
constexpr double k_margin = 0x1p-10;  // voxels: distance that the proxy keeps from a wall

/// A voxel reached by a search.
struct Node {
  ivec3 voxel;
  float cost, estimate;  ///< mm, so far and of the whole path
  std::int16_t parent;
  std::int16_t length;
  bool is_closed;
};

/// A* over free voxels that share faces (Hart, Nilsson and Raphael 1968), near a plane.
template <class Grid>
class VoxelSearch {
 public:
  VoxelSearch(const TouchScene& scene, const Grid& grid, const ShapeSet& passable, const ShapeSet& inside,
              ProxyCounters& counters) noexcept
      : scene_(scene), grid_(grid), passable_(passable), inside_(inside), counters_(counters) {}

  /// Searches from `start` toward `target` (volume frame), through voxels with centres within `depth` voxels
  /// of the plane through `point` with `normal` (volume frame gradient, unit). Returns the node nearest to
  /// the target.
  int run(const ivec3& start, const dvec3& target, const dvec3& point, const dvec3& normal,
          double depth) noexcept {
    target_ = target;
    const ivec3 goal = volume::voxel_of(target);
    count_ = 0;
    open(start, 0, -1, 0);
    int best = 0, idle = 0;
    for (int i = 0; i < k_max_nodes && idle < k_max_idle; ++i) {
      int next = -1;
      for (int n = 0; n < count_; ++n)
        if (!at(n).is_closed && (next < 0 || at(n).estimate < at(next).estimate)) next = n;
      if (next < 0) break;
      at(next).is_closed = true;
      ++idle;
      if (at(next).estimate - at(next).cost < at(best).estimate - at(best).cost) best = next, idle = 0;
      if (at(next).voxel == goal || at(next).length == k_max_length) break;
      for (int axis = 0; axis < 3; ++axis)
        for (int step = -1; step <= 1; step += 2) {
          ivec3 v = at(next).voxel;
          v[axis] += step;
          if (std::abs(glm::dot(dvec3(v) - point, normal)) > depth || !is_free(v)) continue;
          const auto cost = at(next).cost + static_cast<float>(grid_.frame().spacing()[axis]);
          open(v, cost, static_cast<std::int16_t>(next), static_cast<std::int16_t>(at(next).length + 1));
        }
    }
    return best;
  }
  Node& at(int i) noexcept { return nodes_[static_cast<std::size_t>(i)]; }

 private:
  bool is_free(const ivec3& v) noexcept {
    ++counters_.voxels;
    for (std::size_t s = 0; s < scene_.items.size(); ++s) {
      if (passable_.contains(static_cast<int>(s))) continue;
      const bool was = inside_.contains(static_cast<int>(s));
      if (grid_.is_solid(s, v) != was) return false;
    }
    return true;
  }
  void open(const ivec3& v, float cost, std::int16_t parent, std::int16_t length) noexcept {
    for (int n = 0; n < count_; ++n)
      if (at(n).voxel == v) {
        if (!at(n).is_closed && cost < at(n).cost) {
          at(n).estimate += cost - at(n).cost;
          at(n).cost = cost;
          at(n).parent = parent;
          at(n).length = length;
        }
        return;
      }
    if (count_ == k_max_nodes) return;
    const dvec3 remaining = grid_.frame().vector_world_from_volume(target_ - dvec3(v));
    at(count_++) = {v, cost, cost + static_cast<float>(glm::length(remaining)), parent, length, false};
  }

  const TouchScene& scene_;
  const Grid& grid_;
  ShapeSet passable_, inside_;
  ProxyCounters& counters_;
  dvec3 target_{0.0};
  std::array<Node, k_max_nodes> nodes_;
  int count_ = 0;
};

/// Returns p moved into the cube of voxel v, a little off its faces.
dvec3 clamp_to_voxel(const dvec3& p, const ivec3& v) noexcept {
  dvec3 q = p;
  for (int a = 0; a < 3; ++a) q[a] = std::clamp(p[a], v[a] - 0.5 + k_margin, v[a] + 0.5 - k_margin);
  return q;
}

template <class Grid>
void step_on_cubes(const TouchScene& scene, const Grid& grid, const ProxyInput& input, ProxyState& state,
                   ProxyStep& result) noexcept {
  if (begin_on_cubes(scene, grid, input.hip_world, state, result)) return;
  const volume::Frame& frame = grid.frame();
  const dvec3 hip = frame.volume_from_world(input.hip_world);
  const auto energy = [&](const dvec3& p) { return squared_mm(frame, p, hip); };
  result.add_waypoint(state.proxy_volume);
  int landing = 0;
  ShapeSet inside = state.inside;
  ++result.counters.iterations;
  const MotionEnd barrier =
      find_barrier(scene, grid, state.proxy_volume, hip, state.around.passable, inside, result.counters);
  if (!barrier.is_blocked) {
    result.add_waypoint(hip);
  } else {
    // Moves to the wall. The voxel before the wall is free. The motion to the clamped point leaves the traced
    // line, so this motion is tested again.
    dvec3 p = clamp_to_voxel(state.proxy_volume + barrier.t * (hip - state.proxy_volume), barrier.before);
    ShapeSet after = state.inside;
    if (find_barrier(scene, grid, state.proxy_volume, p, state.around.passable, after, result.counters)
            .is_blocked)
      p = state.proxy_volume;
    else if (energy(p) < energy(state.proxy_volume))
      result.add_waypoint(p);
    else
      p = state.proxy_volume;
    const ivec3 start = volume::voxel_of(p);
    dvec3 normal = grid.normal(static_cast<std::size_t>(barrier.shape), p, result.counters.cells);
    if (barrier.is_back) normal = -normal;
    const dvec3 p_world = frame.world_from_volume(p);
    const double height = glm::dot(input.hip_world - p_world, normal);
    if (height >= 0 || normal == dvec3(0)) {
      // A normal along the motion does not describe this wall: the normal of the voxel's face replaces it.
      normal = voxel_face_normal(frame, barrier.face);
    }
    landing = landing_of_first_leg(result);
    result.set_contact(barrier.shape, side_of(barrier.is_back), normal);
    const dvec3 projected_world = input.hip_world - glm::dot(input.hip_world - p_world, normal) * normal;
    VoxelSearch search(scene, grid, state.around.passable, inside, result.counters);
    // A normal is a covector: in the volume frame it is axes^T n.
    const dvec3 across = glm::normalize(normal * frame.axes());
    const int found =
        search.run(start, frame.volume_from_world(projected_world), p, across, PathProxy::k_depth);
    // The new proxy is the point at which the line from the found voxel's centre to the HIP leaves the voxel,
    // or the HIP if it is inside the voxel.
    const ivec3 v = search.at(found).voxel;
    const dvec3 centre(v), to_hip = hip - centre;
    double leave = 1;
    for (int a = 0; a < 3; ++a)
      if (to_hip[a] != 0) leave = std::min(leave, 0.5 / std::abs(to_hip[a]));
    const dvec3 candidate = clamp_to_voxel(centre + leave * to_hip, v);
    if (energy(candidate) < energy(p)) {
      std::array<ivec3, k_max_length + 1> route;
      int length = 0;
      for (int n = found; n > 0; n = search.at(n).parent)
        route[static_cast<std::size_t>(length++)] = search.at(n).voxel;
      // Leads through the centres of the voxels; each leg stays in two cubes that share a face.
      if (length > 0) result.add_waypoint(dvec3(start));
      for (int i = length - 1; i >= 0; --i) result.add_waypoint(dvec3(route[static_cast<std::size_t>(i)]));
      result.add_waypoint(candidate);
    }
  }
  end_on_cubes(scene, grid, input.hip_world, landing, state, result);
}

}  // namespace

Status PathProxy::prepare(const TouchScene& scene) {
  if (Status error = check_burr_opens_voxels(scene)) return error;
  return check_touchable(scene, info());
}

ProxyStep PathProxy::step(const TouchScene& scene, const TouchState& touch_state, ProxyState& state,
                          const ProxyInput& input) const noexcept {
  return step_on_grid(scene, touch_state, state, input,
                      [&](const auto& grid, ProxyState& on_grid, ProxyStep& result) {
                        step_on_cubes(scene, grid, input, on_grid, result);
                      });
}

}  // namespace trephine::haptics::baselines
