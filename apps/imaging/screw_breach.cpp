#include "apps/imaging/screw_breach.h"

#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

namespace trephine::imaging {

using glm::dvec3;

ScrewBreach breach_of(const data_tools::ScrewPosition& screw, const Subject& subject) {
  constexpr double k_along = 0.25, k_back = 0.05;  // mm
  constexpr double k_max_diameters = 3;
  constexpr int k_around = 72;
  const volume::BoneClassifier is_bone(*subject.scan, *subject.bone, subject.version.get());
  const dvec3 shaft = screw.tip_world - screw.entry_world, along = glm::normalize(shaft);
  const dvec3 u = glm::normalize(
                  glm::cross(along, std::abs(along.z) < 0.9 ? dvec3(0, 0, 1) : dvec3(1, 0, 0))),
              v = glm::cross(along, u);
  const double radius = 0.5 * screw.diameter,
               end = glm::length(shaft) - data_tools::k_screw_tip * screw.diameter;
  const auto outward = [&](int i) {
    const double angle = 2 * 3.14159265358979323846 * i / k_around;
    return std::cos(angle) * u + std::sin(angle) * v;
  };
  ScrewBreach worst;
  worst.has_bone = false;
  bool has_entered = false;
  double entered_at = 0;
  for (double s = 0; s <= end; s += k_along) {
    const dvec3 axis = screw.entry_world + s * along;
    if (!worst.has_bone) {
      if (!is_bone(axis)) continue;
      worst.has_bone = true;
      entered_at = s;
    }
    // The surface of the bone may be oblique at the entry, so that a screw is in bone on one side only. The
    // search for breaches starts at the first cross-section that is all in bone, or one diameter after the
    // axis entered bone.
    if (!has_entered) {
      bool is_whole = true;
      for (int i = 0; i < k_around && is_whole; ++i) is_whole = is_bone(axis + radius * outward(i));
      has_entered = is_whole || s - entered_at > screw.diameter;
      if (!has_entered) continue;
    }
    const auto distance_to_bone = [&](const dvec3& from, const dvec3& direction, double max_distance) {
      double distance = 0;
      while (distance < max_distance && !is_bone(from + distance * direction)) distance += k_back;
      return std::min(distance, max_distance);
    };
    double breach = 0;
    dvec3 breach_direction(0);
    if (is_bone(axis)) {
      for (int i = 0; i < k_around; ++i)
        if (const double depth = distance_to_bone(axis + radius * outward(i), -outward(i), radius);
            depth > breach)
          breach = depth, breach_direction = outward(i);
    } else {  // outside bone: the breach points away from the nearest bone
      double nearest = k_max_diameters * screw.diameter;
      for (int i = 0; i < k_around; ++i)
        if (const double distance = distance_to_bone(axis, outward(i), nearest); distance < nearest || i == 0)
          nearest = distance, breach_direction = -outward(i);
      breach = nearest + radius;
    }
    if (breach <= worst.mm) continue;
    worst.mm = breach;
    worst.from_entry_mm = s, worst.at_world = axis + radius * breach_direction,
    worst.outward = breach_direction;
  }
  return worst;
}

std::string side_of_patient(const dvec3& direction) {
  const dvec3 size = glm::abs(direction);
  if (size.x >= size.y && size.x >= size.z)
    return direction.x > 0 ? "the patient's left" : "the patient's right";
  if (size.y >= size.z) return direction.y > 0 ? "the back" : "the front";
  return direction.z > 0 ? "the head" : "the feet";
}

}  // namespace trephine::imaging
