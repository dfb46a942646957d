#include "apps/verify/friction_judge.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <optional>

namespace trephine::verify {

using glm::dvec3;

double distance_from_cone(const dvec3& pull, const std::vector<dvec3>& normals, double coefficient) {
  // Each wall exerts a force in its own cone. The problem is convex: optimize one force after the other until
  // the length of the sum no longer decreases.
  std::vector<dvec3> forces(normals.size(), dvec3(0));
  dvec3 sum = pull;
  double before = glm::length(pull);
  for (int round = 0; round < 2000; ++round) {
    for (std::size_t i = 0; i < normals.size(); ++i) {
      sum -= forces[i];
      // Force of the cone that is nearest to the force that would cancel the rest.
      const dvec3 target = -sum;
      const double press = glm::dot(target, normals[i]);
      const dvec3 along = target - press * normals[i];
      const double tangential = glm::length(along);
      if (tangential <= coefficient * press)
        forces[i] = target;
      else if (const double normal_part =
                   (press + coefficient * tangential) / (1 + coefficient * coefficient);
               normal_part > 0 && tangential > 0)
        forces[i] = normal_part * (normals[i] + coefficient / tangential * along);
      else
        forces[i] = normal_part > 0 ? normal_part * normals[i] : dvec3(0);
      sum += forces[i];
    }
    const double length = glm::length(sum);
    if (before - length < 1e-9 * glm::length(pull)) break;
    before = length;
  }
  return glm::length(sum);
}

namespace {

std::optional<dvec3> normal_at(const SurfaceValue& value, const dvec3& p, double step, double& slope) {
  dvec3 gradient;
  for (int a = 0; a < 3; ++a) {
    dvec3 offset(0);
    offset[a] = step;
    gradient[a] = (value(p + offset) - value(p - offset)) / (2 * step);
  }
  slope = glm::length(gradient);
  if (!(slope > 0)) return std::nullopt;
  return -gradient / slope;
}

}  // namespace

std::vector<dvec3> walls_at(const SurfaceValue& value, const dvec3& position, double step, double reach) {
  std::vector<dvec3> walls;
  double slope = 0;
  const auto here = normal_at(value, position, step, slope);
  if (!here) return walls;
  walls.push_back(*here);
  if (!(reach > 0)) return walls;
  const double same_cosine = std::cos(10 / 57.29577951308232);
  // Finds points of the surface around the position by Newton's method, from 27 points of a cube's grid.
  const auto normals_within = [&](double radius) {
    std::vector<dvec3> normals;
    for (int n = 0; n < 27; ++n) {
      dvec3 p = position + radius * dvec3(n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1);
      for (int i = 0; i < 8; ++i) {
        const auto normal = normal_at(value, p, step, slope);
        if (!normal) break;
        const double error = value(p) / slope;
        p += std::clamp(error, -radius, radius) * *normal;
        if (std::abs(error) > 0.05 * radius) continue;
        if (glm::length(p - position) <= 2 * radius) normals.push_back(*normal_at(value, p, step, slope));
        break;
      }
    }
    return normals;
  };
  const double near = reach / 8;
  double bend = 0;  // radians between two points that are up to 2 `near` apart
  for (const dvec3& a : normals_within(near))
    bend = std::max(bend, std::acos(std::clamp(glm::dot(a, walls[0]), -1.0, 1.0)));
  if (bend * reach < 2 * near) return walls;
  for (const double radius : {near, 0.25 * reach, 0.5 * reach, reach})
    for (const dvec3& one : normals_within(radius))
      if (std::none_of(walls.begin(), walls.end(),
                       [&](const dvec3& other) { return glm::dot(one, other) > same_cosine; }))
        walls.push_back(one);
  return walls;
}

}  // namespace trephine::verify
