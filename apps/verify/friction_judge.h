// Judges friction: while a tool rests on walls, the pull of the hand is inside the sum of the walls' Coulomb
// friction cones.
#pragma once

#include <functional>
#include <glm/vec3.hpp>
#include <vector>

namespace trephine::verify {

/// Function of a position, in any frame, that is at least 0 in the solid. Only the position and the
/// inclination of its surface matter; the scale of its values and the unit of the frame do not.
using SurfaceValue = std::function<double(const glm::dvec3&)>;

/// Returns the distance of the pull of a hand (mm, from the proxy to the hand) from the friction cones: the
/// part of the pull that remains if each wall resists as far as friction with this coefficient allows; 0
/// inside. `normals`: unit, out of each wall.
double distance_from_cone(const glm::dvec3& pull, const std::vector<glm::dvec3>& normals, double coefficient);

/// Returns the normals of the walls that touch a position: the normal of the surface there and, if the
/// surface bends with a radius below `reach`, as at an edge or in a groove, its normals within `reach` that
/// differ from each other by more than 10 degrees. Normals are computed from central differences of the
/// value, `step` to each side.
std::vector<glm::dvec3> walls_at(const SurfaceValue& value, const glm::dvec3& position, double step,
                                 double reach);

}  // namespace trephine::verify
