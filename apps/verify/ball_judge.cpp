#include "apps/verify/ball_judge.h"

#include <cmath>

namespace trephine::verify {

using glm::dvec3;

BallJudge::BallJudge(double radius_mm, int directions) : radius_(radius_mm) {
  // A spiral from pole to pole that turns by the golden angle.
  for (int i = 0; i < directions; ++i) {
    const double z = 1 - (2 * i + 1.0) / directions, across = std::sqrt(1 - z * z),
                 angle = 2.399963229728653 * i;
    directions_.emplace_back(across * std::cos(angle), across * std::sin(angle), z);
  }
}

double BallJudge::penetration_mm(const dvec3& middle, const IsSolid& is_solid) const {
  if (is_solid(middle)) return radius_;
  double nearest = radius_;
  for (const dvec3& direction : directions_)
    // Test at the nearest distance so far. Also test at shorter distances, for thin matter that ends before
    // it.
    for (const double share : {1.0, 0.7, 0.4}) {
      double matter = share * nearest, free = 0;
      if (!is_solid(middle + matter * direction)) continue;
      for (int k = 0; k < 12; ++k) {
        const double between = 0.5 * (free + matter);
        (is_solid(middle + between * direction) ? matter : free) = between;
      }
      nearest = matter;
    }
  return radius_ - nearest;
}

}  // namespace trephine::verify
