// Judges friction: where a tool holds still on a wall, the pull of the hand lies in Coulomb's cone around
// what the walls press, each wall with its own share.
#pragma once

#include <functional>
#include <glm/vec3.hpp>
#include <vector>

namespace trephine::checker {

/// A solid around a place, in any frame: its value (solid from 0 up) and the mm of one unit of that frame are
/// not needed; only where its surface lies and how it is inclined.
using SurfaceValue = std::function<double(const glm::dvec3&)>;

/// Returns by how much the pull of a hand (mm, from the proxy to the hand) lies outside the cone: what is
/// left of it when each wall holds as well as friction of this coefficient lets it; 0 inside. `normals`:
/// unit, out of each wall.
double beyond_cone(const glm::dvec3& pull, const std::vector<glm::dvec3>& normals, double coefficient);

/// The walls that touch a place: the normal of the surface there; and, where the surface bends with a radius
/// below `reach`, as at an edge or in a groove, all normals of it within `reach`. By differences of the value
/// over `step`.
std::vector<glm::dvec3> walls_at(const SurfaceValue& value, const glm::dvec3& place, double step,
                                 double reach);

}  // namespace trephine::checker
