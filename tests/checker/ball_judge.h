// How far does a ball reach into matter? By asking many of its points whether they are solid: shares nothing
// with fields of distances.
#pragma once

#include <functional>
#include <glm/vec3.hpp>
#include <vector>

namespace trephine::checker {

class BallJudge {
 public:
  /// Is this place (world frame) in matter?
  using IsSolid = std::function<bool(const glm::dvec3&)>;
  /// `directions`: how many ways from the middle outward are asked, evenly spread.
  explicit BallJudge(double radius_mm, int directions = 600);

  /// The radius less the distance (mm) of the nearest matter that was found; 0 where the ball is free. Never
  /// more than the truth; less by what hides between two directions.
  double sunk_mm(const glm::dvec3& middle_world, const IsSolid& is_solid) const;

 private:
  double radius_;
  std::vector<glm::dvec3> ways_;
};

}  // namespace trephine::checker
