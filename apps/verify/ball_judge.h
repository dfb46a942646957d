// BallJudge: depth of a ball in matter, by testing many of its points for matter. Shares no code and no data
// with distance fields.
#pragma once

#include <functional>
#include <glm/vec3.hpp>
#include <vector>

namespace trephine::verify {

class BallJudge {
 public:
  /// Returns true if a position (world frame, mm) is in matter.
  using IsSolid = std::function<bool(const glm::dvec3&)>;
  /// `directions`: number of evenly spread directions from the centre outward that are tested.
  explicit BallJudge(double radius_mm, int directions = 600);

  /// Returns the radius less the distance of the nearest matter that was found, mm; 0 if the ball is free.
  /// Never more than the true depth; matter between two directions may be missed.
  double penetration_mm(const glm::dvec3& middle_world, const IsSolid& is_solid) const;

 private:
  double radius_;
  std::vector<glm::dvec3> directions_;
};

}  // namespace trephine::verify
