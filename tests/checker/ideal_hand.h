// Where an exact hand's proxy would be, near any wall that can be asked how far it is. Works from that answer
// alone; shares no code with what it judges.
#pragma once

#include <functional>
#include <glm/vec3.hpp>

namespace trephine::checker {

/// How far a place (mm) is from matter: positive where the tool may be, negative in matter. Continuous, and
/// of finite slopes; near the wall a distance up to a factor.
using Clearance = std::function<double(const glm::dvec3&)>;

/// A frictionless proxy comes down |p - HIP| through free places only, while the HIP goes straight from
/// `hip_from` to `hip_to` in steps of at most `step`. Walls may be smooth, or have edges and corners of up to
/// three sides; a wall thinner than `step` may be missed. A proxy that lies in the wall is led out first.
/// Right to about 1e-4 of a step.
glm::dvec3 follow_exactly(const Clearance& clearance, double step, glm::dvec3 proxy,
                          const glm::dvec3& hip_from, const glm::dvec3& hip_to);

}  // namespace trephine::checker
