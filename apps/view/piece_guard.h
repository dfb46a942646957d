// PieceGuard: moves a held piece up to bone and structures, and along them, instead of through them.
#pragma once

#include <functional>
#include <glm/vec3.hpp>
#include <vector>

#include "haptics/mesh/mesh_tree.h"
#include "haptics/scene/touch_scene.h"

namespace trephine::view {

/// A mouse has no force that stops the hand, so the guard stops the piece. Samples of its vertices represent
/// the piece: a part of the anatomy that fits between two samples may enter it.
class PieceGuard {
 public:
  /// Returns true if a point (world, mm) is in matter that stops the piece.
  using Obstacle = std::function<bool(const glm::dvec3& at_world)>;

  /// `grip`: pose of the surface relative to the hand.
  PieceGuard(const haptics::MeshTree& surface, const haptics::Placement& grip);

  /// Returns the pose that the hand reaches on its way to `to`, at most 30 mm per call. A sample that is in
  /// an obstacle at `from`, as in the gap of a kerf, does not stop the piece. The piece turns at the start of
  /// the motion, and only if it fits there.
  haptics::Placement move(const haptics::Placement& from, const haptics::Placement& to,
                          const Obstacle& is_obstacle);
  /// Number of samples that stopped the last move.
  std::size_t contacts() const noexcept { return contacts_; }

 private:
  bool fits(const haptics::Placement& hand, const Obstacle& is_obstacle);
  glm::dvec3 normal(const haptics::Placement& hand, const Obstacle& is_obstacle) const;

  std::vector<glm::dvec3> samples_;    ///< mm, in the frame of the hand
  std::vector<bool> is_free_;          ///< per sample: outside obstacles at the start of a move
  std::vector<std::size_t> stopping_;  ///< samples in an obstacle at the pose of the last fits()
  std::size_t contacts_ = 0;
};

}  // namespace trephine::view
