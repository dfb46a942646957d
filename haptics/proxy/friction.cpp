#include "haptics/proxy/friction.h"

#include <algorithm>
#include <glm/geometric.hpp>

namespace trephine::haptics {

glm::dvec3 apply_friction(const volume::Frame& frame, const Material& material, const glm::dvec3& hip_world,
                          int landing, ProxyStep& step, bool& is_sticking) noexcept {
  const auto waypoint = [&step](int i) -> glm::dvec3& {
    return step.path_volume[static_cast<std::size_t>(i)];
  };
  const glm::dvec3& normal = step.normal_world;
  const auto tangential = [&normal](const glm::dvec3& v) {
    return glm::length(v - glm::dot(v, normal) * normal);
  };
  const glm::dvec3 ideal_world = frame.world_from_volume(waypoint(step.waypoint_count - 1));
  const double depth = std::max(0.0, glm::dot(ideal_world - hip_world, normal));
  const double slide = tangential(ideal_world - frame.world_from_volume(waypoint(0)));
  is_sticking = slide <= (is_sticking ? material.static_friction : material.dynamic_friction) * depth;

  const int first = std::min(landing, step.waypoint_count - 1);
  if (is_sticking) {
    step.waypoint_count = first + 1;
    return waypoint(first);
  }
  double back = material.dynamic_friction * depth;
  while (step.waypoint_count - 1 > first && back > 0) {
    glm::dvec3& end = waypoint(step.waypoint_count - 1);
    const glm::dvec3 begin = waypoint(step.waypoint_count - 2);
    const double length = tangential(frame.vector_world_from_volume(end - begin));
    if (length > back) {
      end = begin + (1 - back / length) * (end - begin);
      break;
    }
    back -= length;
    --step.waypoint_count;
  }
  return waypoint(step.waypoint_count - 1);
}

int landing_of_first_leg(const ProxyStep& step) noexcept {
  if (step.waypoint_count < 2) return 0;
  const glm::dvec3 drop = step.path_volume[1] - step.path_volume[0];
  constexpr double k_support = 0.1;
  return glm::dot(drop, drop) > k_support * k_support ? 1 : 0;
}

}  // namespace trephine::haptics
