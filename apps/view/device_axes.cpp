#include "apps/view/device_axes.h"

#include <algorithm>
#include <glm/gtc/quaternion.hpp>

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

}  // namespace trephine::view
