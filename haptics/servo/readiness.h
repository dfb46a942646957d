// Readiness: which items of a hand cannot block it yet, because their data do not reach it.
#pragma once

#include <optional>

#include "haptics/servo/servo_scene.h"

namespace trephine::haptics {

/// Hand and proxy at the time of a tick.
struct ReadinessQuery {
  glm::dvec3 hip_world{0.0}, proxy_world{0.0};
  double time = 0;        ///< s
  int touched_item = -1;  ///< that the proxy touched in the previous tick; -1: no contact
};
struct Readiness {
  ShapeSet not_ready;
  /// Largest part of the force limit for the touched item, whose data are overdue; empty: no limit.
  std::optional<double> fade = std::nullopt;
};

/// Finds the items that cannot block yet. A partly available item blocks within its part: around hand and
/// proxy, with the voxels that are read around them. An item touched by depth images blocks where these show
/// its surface, and fades when new images are overdue. Servo thread.
Readiness readiness_of(const ServoHand& hand, const ReadinessQuery& query) noexcept;

}  // namespace trephine::haptics
