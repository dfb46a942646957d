// Readiness: items that cannot block a hand yet, because their data around the hand are not available.
#pragma once

#include <optional>

#include "haptics/servo/servo_scene.h"

namespace trephine::haptics {

/// Hand and proxy at the time of a tick.
struct ReadinessQuery {
  glm::dvec3 hip_world{0.0}, proxy_world{0.0};
  double time = 0;        ///< s
  int touched_item = -1;  ///< item that the proxy touched in the previous tick; -1: no contact
};
struct Readiness {
  ShapeSet not_ready;
  /// Share of the force limit, 0 to 1, that is left while depth images of the touched item are overdue;
  /// empty: the whole limit.
  std::optional<double> fade = std::nullopt;
};

/// Finds the items that cannot block yet. A partly available item blocks if its available part contains hand
/// and proxy, with the extent of the tool and the voxels that are read around it. An item touched by depth
/// images blocks where the images show its surface; its force fades when new images are overdue. Servo
/// thread.
Readiness readiness_of(const ServoHand& hand, const ReadinessQuery& query) noexcept;

}  // namespace trephine::haptics
