#include "tests/checker/passage_judge.h"

#include <cmath>
#include <glm/geometric.hpp>

namespace trephine::checker {

using glm::dvec3;

bool PassageJudge::has_way_around(const dvec3& out, const dvec3& out_normal) const {
  constexpr int k_directions = 24;
  const dvec3 across = out - in_;
  if (glm::length(across) > 4 * pixel_) return false;
  const dvec3 along = glm::length(across) > 1e-12 ? glm::normalize(across) : -in_normal_;
  const dvec3 other = std::abs(along.z) < 0.9 ? dvec3(0, 0, 1) : dvec3(1, 0, 0);
  const dvec3 u = glm::normalize(glm::cross(along, other)), v = glm::cross(along, u);
  const dvec3 from = in_ + 1e-3 * pixel_ * in_normal_, to = out + 1e-3 * pixel_ * out_normal;
  for (const double far : {0.5, 1.0, 1.5, 2.0, 3.0})
    for (int i = 0; i < k_directions; ++i) {
      const double angle = 2 * 3.14159265358979 * i / k_directions;
      const dvec3 aside = far * pixel_ * (std::cos(angle) * u + std::sin(angle) * v);
      const dvec3 first = from + aside + 0.5 * far * pixel_ * in_normal_,
                  second = to + aside + 0.5 * far * pixel_ * out_normal;
      if (!model_.is_crossed(from, first) && !model_.is_crossed(first, second) &&
          !model_.is_crossed(second, to))
        return true;
    }
  return false;
}

bool PassageJudge::goes(const dvec3& a, const dvec3& b) {
  if (where_ == Where::unknown) where_ = model_.is_inside(a) ? Where::inside : Where::free, winding_ = 0;
  if (where_ == Where::inside) {  // it began in matter: nothing holds it out of that
    if (!model_.is_inside(b)) where_ = Where::free, winding_ = 0;
    return false;
  }
  bool has_passed = false;
  for (const MeshWall::Crossing& crossing : model_.crossings_along(a, b)) {
    const dvec3 at = a + crossing.at * (b - a);
    if (glm::dot(crossing.normal, b - a) < 0) {
      if (winding_++ == 0) in_ = at, in_normal_ = crossing.normal;
    } else if (--winding_ == 0) {
      // Out on the side where it went in: a chord of a surface that curves away.
      if (glm::dot(crossing.normal, in_normal_) < 0 && !has_way_around(at, crossing.normal))
        has_passed = true;
    }
  }
  where_ = winding_ > 0 ? Where::grazing : Where::free;
  if (where_ == Where::grazing && !model_.is_near(b, 1.5 * pixel_)) {
    has_passed = true;
    where_ = Where::inside;
  }
  return has_passed;
}

}  // namespace trephine::checker
