#include "apps/view/device_axes.h"

#include <algorithm>
#include <cmath>
#include <glm/gtc/quaternion.hpp>
#include <numbers>

namespace trephine::view {

glm::dquat screen_axes(Viewport& viewport) {
  const volume::Camera camera = viewport.camera();
  return glm::quat_cast(glm::dmat3(camera.right(), camera.up, -camera.forward));
}

glm::dvec3 device_start(Viewport& viewport, const volume::Version& version) {
  constexpr double k_ahead = 30;  // mm
  const Ray ray = viewport.ray_at(0.5, 0.5);
  const double hit = viewport.distance_to_solid(version, ray);
  if (hit < 0) return viewport.outside_point();
  return ray.origin + std::max(hit - k_ahead, 0.0) * ray.direction;
}

sim::Overlay workspace_overlay(const haptics::Workspace& workspace) {
  constexpr int k_segments = 64;
  sim::Overlay overlay;
  for (int axis = 0; axis < 3; ++axis) {
    const auto at = [&](int i) {
      const double angle = 2 * std::numbers::pi * i / k_segments;
      glm::dvec3 p(0);
      p[axis] = std::cos(angle), p[(axis + 1) % 3] = std::sin(angle);
      return workspace.centre_world + workspace.radius * p;
    };
    for (int i = 0; i < k_segments; ++i) overlay.lines.push_back({at(i), at(i + 1)});
  }
  return overlay;
}

}  // namespace trephine::view
