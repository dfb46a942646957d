// PassageJudge: judges paths by the triangles of closed models, for methods that know these models only
// through images. Such a method may be off by a pixel, but its proxy must not leave on the other side of a
// wall.
#pragma once

#include "apps/verify/mesh_judge.h"

namespace trephine::verify {

class PassageJudge {
 public:
  /// `pixel`: pixel size of the images, in the units of the model.
  PassageJudge(MeshWall model, double pixel) : model_(std::move(model)), pixel_(pixel) {}

  /// Forgets the last position. Call after the tool was set to another position without a motion.
  void restart() { state_ = State::unknown; }
  /// Judges a straight motion from the last position `a` to `b`. Returns true if it passed through a wall, or
  /// entered matter deeper than 1.5 pixels, the tolerance of the images.
  bool passes(const glm::dvec3& a, const glm::dvec3& b);

 private:
  /// Returns true if a short path leads around the matter between entry and exit, as around an edge or a tip.
  bool has_detour(const glm::dvec3& exit_point, const glm::dvec3& exit_normal) const;

  MeshWall model_;
  double pixel_;
  enum class State : std::uint8_t { unknown, free, grazing, inside } state_ = State::unknown;
  int winding_ = 0;
  glm::dvec3 entry_{0.0}, entry_normal_{0.0};  ///< where the tool entered matter, and the normal there
};

}  // namespace trephine::verify
