// Judges a way by the triangles of closed models, for methods that know these only through images: to be off
// by a pixel is what such a method may, to come out on the other side of a wall is not.
#pragma once

#include "tests/checker/mesh_judge.h"

namespace trephine::checker {

class PassageJudge {
 public:
  /// `pixel`: of the images, in the units of the model.
  PassageJudge(MeshWall model, double pixel) : model_(std::move(model)), pixel_(pixel) {}

  /// The tool was set down somewhere; the next way begins there.
  void restart() { where_ = Where::unknown; }
  /// The tool went straight from a to b, from where it was last. Returns whether it went through a wall, or
  /// into matter deeper than the images can be off.
  bool goes(const glm::dvec3& a, const glm::dvec3& b);

 private:
  /// Does some short way lead around the matter between the two places, as around a sharp edge or a tip?
  bool has_way_around(const glm::dvec3& out, const glm::dvec3& out_normal) const;

  MeshWall model_;
  double pixel_;
  enum class Where : std::uint8_t { unknown, free, grazing, inside } where_ = Where::unknown;
  int winding_ = 0;
  glm::dvec3 in_{0.0}, in_normal_{0.0};  ///< where the tool went into matter
};

}  // namespace trephine::checker
