// follow_exactly(): ideal proxy near any wall with a clearance function. Uses that function alone; shares no
// code with the judged code.
#pragma once

#include <functional>
#include <glm/vec3.hpp>

namespace trephine::verify {

/// Clearance of a position (mm) from matter: positive where the tool may be, negative in matter. Continuous
/// with finite slopes. Near the wall it is the distance from the wall times a positive factor.
using Clearance = std::function<double(const glm::dvec3&)>;

/// Returns a frictionless proxy that descends |p - HIP| through free space only, while the HIP moves straight
/// from `hip_from` to `hip_to` in steps of at most `step` (mm). Walls may be smooth, or have edges and
/// corners of up to three sides; a wall thinner than `step` may be missed. A proxy in the wall is moved out
/// first. Accurate to about 1e-4 of a step.
glm::dvec3 follow_exactly(const Clearance& clearance, double step, glm::dvec3 proxy,
                          const glm::dvec3& hip_from, const glm::dvec3& hip_to);

}  // namespace trephine::verify
