// Landmarks of the head phantom, for plans: points on its bone, its skin and its ventricles.
#pragma once

#include "data-tools/phantoms/head_phantom.h"

namespace trephine::data_tools {

/// Points of a head, world frame, mm.
struct HeadLandmarks {
  struct Side {
    glm::dvec3 tragus{0.0};  ///< on the skin
    glm::dvec3 kochers_point{
        0.0};  ///< on the vault: 11 cm from the nasion along the midline, then 3 cm to the side
    glm::dvec3 foramen_of_monro{0.0};  ///< in the lateral ventricle, at its medial wall
  };
  glm::dvec3 vertex{0.0}, inion{0.0}, nasion{0.0}, glabella{0.0};  ///< on bone
  Side left, right;
};
/// Finds the landmarks of an anatomy; deterministic. Takes some milliseconds.
HeadLandmarks head_landmarks(const HeadAnatomy& anatomy);

}  // namespace trephine::data_tools
