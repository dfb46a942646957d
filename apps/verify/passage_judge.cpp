#include "apps/verify/passage_judge.h"

#include <cmath>
#include <glm/geometric.hpp>

namespace trephine::verify {

using glm::dvec3;

bool PassageJudge::has_detour(const dvec3& exit_point, const dvec3& exit_normal) const {
  constexpr int k_directions = 24;
  const dvec3 across = exit_point - entry_;
  if (glm::length(across) > 4 * pixel_) return false;
  const dvec3 along = glm::length(across) > 1e-12 ? glm::normalize(across) : -entry_normal_;
  const dvec3 other = std::abs(along.z) < 0.9 ? dvec3(0, 0, 1) : dvec3(1, 0, 0);
  const dvec3 u = glm::normalize(glm::cross(along, other)), v = glm::cross(along, u);
  const dvec3 from = entry_ + 1e-3 * pixel_ * entry_normal_, to = exit_point + 1e-3 * pixel_ * exit_normal;
  for (const double distance : {0.5, 1.0, 1.5, 2.0, 3.0})
    for (int i = 0; i < k_directions; ++i) {
      const double angle = 2 * 3.14159265358979 * i / k_directions;
      const dvec3 offset = distance * pixel_ * (std::cos(angle) * u + std::sin(angle) * v);
      const dvec3 first = from + offset + 0.5 * distance * pixel_ * entry_normal_,
                  second = to + offset + 0.5 * distance * pixel_ * exit_normal;
      if (!model_.is_crossed(from, first) && !model_.is_crossed(first, second) &&
          !model_.is_crossed(second, to))
        return true;
    }
  return false;
}

bool PassageJudge::passes(const dvec3& a, const dvec3& b) {
  if (state_ == State::unknown) state_ = model_.is_inside(a) ? State::inside : State::free, winding_ = 0;
  if (state_ == State::inside) {  // a path that begins in matter is not judged
    if (!model_.is_inside(b)) state_ = State::free, winding_ = 0;
    return false;
  }
  bool has_passed = false;
  for (const MeshWall::Crossing& crossing : model_.crossings_along(a, b)) {
    const dvec3 at = a + crossing.at * (b - a);
    if (glm::dot(crossing.normal, b - a) < 0) {
      if (winding_++ == 0) entry_ = at, entry_normal_ = crossing.normal;
    } else if (--winding_ == 0) {
      // A path that leaves on the side of its entry only cut through a bump of the surface, which is allowed.
      if (glm::dot(crossing.normal, entry_normal_) < 0 && !has_detour(at, crossing.normal)) has_passed = true;
    }
  }
  state_ = winding_ > 0 ? State::grazing : State::free;
  if (state_ == State::grazing && !model_.is_near(b, 1.5 * pixel_)) {
    has_passed = true;
    state_ = State::inside;
  }
  return has_passed;
}

}  // namespace trephine::verify
