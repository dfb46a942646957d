#include "tests/checker/friction_judge.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <optional>

namespace trephine::checker {

using glm::dvec3;

double beyond_cone(const dvec3& pull, const std::vector<dvec3>& normals, double coefficient) {
  // Each wall gives a force of its own cone. Convex: one after another is brought to its best, until none
  // changes.
  std::vector<dvec3> forces(normals.size(), dvec3(0));
  dvec3 sum = pull;
  double before = glm::length(pull);
  for (int round = 0; round < 2000; ++round) {
    for (std::size_t i = 0; i < normals.size(); ++i) {
      sum -= forces[i];
      // The force of the cone that is nearest to what would cancel the rest.
      const dvec3 wanted = -sum;
      const double press = glm::dot(wanted, normals[i]);
      const dvec3 along = wanted - press * normals[i];
      const double rub = glm::length(along);
      if (rub <= coefficient * press)
        forces[i] = wanted;
      else if (const double on = (press + coefficient * rub) / (1 + coefficient * coefficient);
               on > 0 && rub > 0)
        forces[i] = on * (normals[i] + coefficient / rub * along);
      else
        forces[i] = on > 0 ? on * normals[i] : dvec3(0);
      sum += forces[i];
    }
    const double now = glm::length(sum);
    if (before - now < 1e-9 * glm::length(pull)) break;
    before = now;
  }
  return glm::length(sum);
}

namespace {

std::optional<dvec3> normal_at(const SurfaceValue& value, const dvec3& p, double step, double& slope) {
  dvec3 gradient;
  for (int a = 0; a < 3; ++a) {
    dvec3 off(0);
    off[a] = step;
    gradient[a] = (value(p + off) - value(p - off)) / (2 * step);
  }
  slope = glm::length(gradient);
  if (!(slope > 0)) return std::nullopt;
  return -gradient / slope;
}

}  // namespace

std::vector<dvec3> walls_at(const SurfaceValue& value, const dvec3& place, double step, double reach) {
  std::vector<dvec3> walls;
  double slope = 0;
  const auto here = normal_at(value, place, step, slope);
  if (!here) return walls;
  walls.push_back(*here);
  if (!(reach > 0)) return walls;
  const double same = std::cos(10 / 57.29577951308232);
  // Places of the surface around: by Newton's steps from points of a shell.
  const auto normals_within = [&](double far) {
    std::vector<dvec3> found;
    for (int n = 0; n < 27; ++n) {
      dvec3 p = place + far * dvec3(n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1);
      for (int i = 0; i < 8; ++i) {
        const auto normal = normal_at(value, p, step, slope);
        if (!normal) break;
        const double off = value(p) / slope;
        p += std::clamp(off, -far, far) * *normal;
        if (std::abs(off) > 0.05 * far) continue;
        if (glm::length(p - place) <= 2 * far) found.push_back(*normal_at(value, p, step, slope));
        break;
      }
    }
    return found;
  };
  const double near = reach / 8;
  double bend = 0;  // radians between two places that are up to 2 `near` apart
  for (const dvec3& a : normals_within(near))
    bend = std::max(bend, std::acos(std::clamp(glm::dot(a, walls[0]), -1.0, 1.0)));
  if (bend * reach < 2 * near) return walls;
  for (const double far : {near, 0.25 * reach, 0.5 * reach, reach})
    for (const dvec3& one : normals_within(far))
      if (std::none_of(walls.begin(), walls.end(),
                       [&](const dvec3& other) { return glm::dot(one, other) > same; }))
        walls.push_back(one);
  return walls;
}

}  // namespace trephine::checker
