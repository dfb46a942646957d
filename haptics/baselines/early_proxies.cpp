#include "haptics/baselines/early_proxies.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "haptics/walls/barrier.h"
#include "haptics/walls/solid_grid.h"

namespace trephine::haptics::baselines {

using glm::dvec3;
using glm::ivec3;

namespace {

constexpr int k_max_steps = 4096;  // samples of a motion; a longer motion is sampled more coarsely

dvec3 unit(const dvec3& v) noexcept {
  const double length = glm::length(v);
  return length > 0 ? v / length : dvec3(0);
}

/// Returns the normal (world frame) at a voxel, toward lower values, by central differences of the
/// intensities. For a label, and beyond the border of the volume, the values are those of the field.
dvec3 voxel_normal(const volume::Field& field, const volume::Frame& frame, const ivec3& v,
                   int& cells) noexcept {
  cells += 6;
  const auto at = [&field](int x, int y, int z) {
    const volume::Volume& base = field.volume();
    if (field.shape().is_label() || !base.contains({x, y, z})) return field.at(x, y, z);
    return static_cast<double>(base.window_voxels()[base.index(x, y, z)]);
  };
  const dvec3 gradient(at(v.x + 1, v.y, v.z) - at(v.x - 1, v.y, v.z),
                       at(v.x, v.y + 1, v.z) - at(v.x, v.y - 1, v.z),
                       at(v.x, v.y, v.z + 1) - at(v.x, v.y, v.z - 1));
  return unit(-frame.gradient_world_from_volume(gradient));
}

/// Returns the first shape with voxel v in its binary transfer function, or -1.
int shape_at(const TouchScene& scene, const volume::Version& version, const ivec3& v) noexcept {
  const VoxelGrid grid(scene, version);
  for (std::size_t s = 0; s < scene.items.size(); ++s)
    if (grid.is_solid(s, v)) return static_cast<int>(s);
  return -1;
}

void finish(const volume::Frame& frame, const dvec3& hip_world, const dvec3& proxy_world, ProxyState& state,
            ProxyStep& result) noexcept {
  result.path_volume[0] = state.has_proxy ? state.proxy_volume : frame.volume_from_world(hip_world);
  result.path_volume[1] = frame.volume_from_world(proxy_world);
  result.waypoint_count = 2;
  result.proxy_world = proxy_world;
  state.has_proxy = true;
  state.had_contact = result.has_contact;
  state.proxy_volume = result.path_volume[1];
}

}  // namespace

Status RaystepProxy::prepare(const TouchScene& scene) {
  if (Status error = check_burr_opens_voxels(scene)) return error;
  return check_touchable(scene, info());
}

ProxyStep RaystepProxy::step(const TouchScene& scene, const TouchState& touch_state, ProxyState& state,
                             const ProxyInput& input) const noexcept {
  const volume::Version& version = *touch_state.version;
  const volume::Frame& frame = version.base().frame;
  const dvec3& end = input.hip_world;
  ProxyStep result;
  result.normal_world = dvec3(0);
  dvec3 proxy = end;
  const dvec3 start = state.has_proxy ? frame.world_from_volume(state.proxy_volume) : end;
  const double length = glm::length(end - start);
  if (state.has_proxy && (length > 0 || state.had_contact)) {
    const int steps = std::min(k_max_steps, static_cast<int>(std::ceil(length / k_step)));
    for (int i = 0; i <= steps; ++i) {
      const double t = steps > 0 ? std::min(1.0, i * (length / steps) / std::max(length, 1e-300)) : 0;
      const dvec3 p = (1 - t) * start + t * end;
      const ivec3 v = volume::voxel_of(glm::clamp(frame.volume_from_world(p), dvec3(-1e6), dvec3(1e6)));
      ++result.counters.voxels;
      const int s = shape_at(scene, version, v);
      if (s < 0) continue;
      dvec3 normal =
          voxel_normal(scene.items[static_cast<std::size_t>(s)].field, frame, v, result.counters.cells);
      const bool is_front = glm::dot(start - p, normal) >= 0 && glm::dot(end - p, normal) <= 0;
      if (!blocks(scene, state.around.passable, s, side_of(!is_front))) break;
      if (!is_front) normal = -normal;
      result.set_contact(s, side_of(!is_front), normal);
      // Stays in the tangent plane at the contact, as close to the HIP as possible.
      const double depth = glm::dot(end - p, normal);
      proxy = depth < 0 ? end - depth * normal : p;
      break;
    }
  }
  finish(frame, end, proxy, state, result);
  return result;
}

Status PlaneProxy::prepare(const TouchScene& scene) { return check_touchable(scene, info()); }

ProxyStep PlaneProxy::step(const TouchScene& scene, const TouchState& touch_state, ProxyState& state,
                           const ProxyInput& input) const noexcept {
  const volume::Version& version = *touch_state.version;
  const volume::Frame& frame = version.base().frame;
  const dvec3& hip = input.hip_world;
  ProxyStep result;
  result.normal_world = dvec3(0);
  PlaneMemory& plane = state.plane;
  if (!state.has_proxy) plane = PlaneMemory{};
  if (plane.age % k_ticks_per_plane == 0) {
    // Finds the plane of the first shape whose surface is within three voxel diagonals of the HIP, along
    // the gradient of the shape's field.
    const dvec3 p = frame.volume_from_world(hip);
    const bool had_plane = plane.shape >= 0;
    const double old_height = had_plane ? glm::dot(hip - plane.point_world, plane.normal_world) : 0;
    plane.shape = -1;
    for (std::size_t s = 0; s < scene.items.size() && plane.shape < 0; ++s) {
      const TouchItem& shape = scene.items[s];
      if (state.around.passable.contains(static_cast<int>(s))) continue;
      const dvec3 normal = outward_normal(shape, version, p, result.counters.cells);
      const double steepness = glm::length(frame.gradient_world_from_volume(shape.field.smooth_gradient(p)));
      result.counters.cells += 40;
      if (!(steepness > 0) || normal == dvec3(0)) continue;
      double height = -shape.field.value(p) / steepness;
      if (version.is_near_cut(p)) height = std::max(height, -version.distance(p));
      if (std::abs(height) > 3 * frame.diagonal_mm()) continue;
      plane.shape = static_cast<int>(s);
      plane.point_world = hip - height * normal;
      plane.normal_world = normal;
    }
    // The jump from the old plane to the new one is removed over the recovery time.
    plane.recovery = had_plane && plane.shape >= 0 && old_height < 0
                         ? old_height - glm::dot(hip - plane.point_world, plane.normal_world)
                         : 0;
    plane.recovery_left = k_recovery;
  }
  ++plane.age;
  dvec3 proxy = hip;
  if (plane.shape >= 0) {
    const double share = std::max(0, plane.recovery_left) / static_cast<double>(k_recovery);
    const double depth = glm::dot(hip - plane.point_world, plane.normal_world) + share * plane.recovery;
    --plane.recovery_left;
    if (depth < 0) {
      result.set_contact(plane.shape, Side::front, plane.normal_world);
      proxy = hip - depth * plane.normal_world;
    }
  }
  finish(frame, hip, proxy, state, result);
  return result;
}

Status GradientProxy::prepare(const TouchScene& scene) { return check_touchable(scene, info()); }

ProxyStep GradientProxy::step(const TouchScene& scene, const TouchState& touch_state, ProxyState& state,
                              const ProxyInput& input) const noexcept {
  const volume::Version& version = *touch_state.version;
  const volume::Frame& frame = version.base().frame;
  const dvec3& hip = input.hip_world;
  ProxyStep result;
  result.normal_world = dvec3(0);
  dvec3 proxy = hip;
  const dvec3 p = frame.volume_from_world(hip);
  for (std::size_t s = 0; s < scene.items.size(); ++s) {
    const TouchItem& shape = scene.items[s];
    if (state.around.passable.contains(static_cast<int>(s))) continue;
    result.counters.cells += 8;
    double depth = shape.field.value(p);
    if (depth < 0) continue;
    const double steepness = glm::length(frame.gradient_world_from_volume(shape.field.smooth_gradient(p)));
    depth = steepness > 0 ? depth / steepness : 0;
    if (version.is_near_cut(p)) depth = std::min(depth, version.distance(p));
    if (!(depth > 0)) continue;
    result.normal_world = outward_normal(shape, version, p, result.counters.cells);
    result.has_contact = result.normal_world != dvec3(0);
    result.shape = static_cast<int>(s);
    result.side = Side::front;
    proxy = hip + std::min(depth, 2 * frame.diagonal_mm()) * result.normal_world;
    break;
  }
  finish(frame, hip, proxy, state, result);
  return result;
}

}  // namespace trephine::haptics::baselines
