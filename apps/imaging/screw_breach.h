// Measures by how much a screw reaches out of bone, and on which side.
#pragma once

#include <optional>

#include "apps/imaging/subject.h"

namespace trephine::imaging {

struct ScrewBreach {
  double mm = 0;  ///< from the shaft's outside back to bone, 0: all of it is in bone; at most 3.5 diameters
  double from_entry_mm = 0;  ///< along the screw
  glm::dvec3 at_world{0.0};  ///< the place on the shaft's outside
  glm::dvec3 outward{0.0};   ///< unit, from the axis to it
  bool has_bone = true;      ///< does the axis meet bone at all?
};
/// The largest breach of a screw's shaft. Neither its head nor its tip counts, nor its way through the
/// surface of the bone where it enters. The subject says what is bone; by places every 0.25 mm along and
/// every 5 degrees around.
ScrewBreach breach_of(const data_tools::ScrewPlace& screw, const Subject& subject);

/// "the patient's left", "the front", ...: the axis of the patient that a direction follows most.
std::string side_of_patient(const glm::dvec3& direction);

}  // namespace trephine::imaging
