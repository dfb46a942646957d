// ScrewBreach: distance by which a screw protrudes from bone, with position and direction.
#pragma once

#include <optional>

#include "apps/imaging/subject.h"

namespace trephine::imaging {

struct ScrewBreach {
  /// Distance from the shaft's surface back to bone, toward the axis; 0: all in bone; at most 3.5 diameters.
  double mm = 0;
  double from_entry_mm = 0;  ///< distance from the entry along the screw
  glm::dvec3 at_world{0.0};  ///< point of the breach on the shaft's surface, mm
  glm::dvec3 outward{0.0};   ///< unit, from the axis to that point
  bool has_bone = true;      ///< the axis meets bone
};
/// Returns the largest breach of a screw's shaft, without its head, its tip and its passage through the
/// surface of the bone at the entry. Requires a subject with `bone`. Samples every 0.25 mm along and every 5
/// degrees around the shaft.
ScrewBreach breach_of(const data_tools::ScrewPosition& screw, const Subject& subject);

/// Returns the side toward which a direction mainly points: "the patient's left", "the front", "the head".
std::string side_of_patient(const glm::dvec3& direction);

}  // namespace trephine::imaging
