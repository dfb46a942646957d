// Preview of a flap before it is cut.
#pragma once

#include "modules/bone_flap/bone_flap.h"
#include "modules/bone_flap/kerf.h"

namespace trephine::bone_flap {

inline Depth depth_of(const CutFlap& request) { return {request.hole, request.space, request.thickest}; }
/// Those that a command names, or else those that were drawn.
template <class Request>
const std::vector<glm::dvec3>& anchors_of(const Request& request, const FlapSettings& drawn) {
  return request.anchors.empty() ? drawn.anchors : request.anchors;
}

const sim::JobType& preview_job();
/// With the outline it goes.
void forget_preview(FlapSettings& settings);
/// The lid, and the walls under its rim; of settings that have one.
sim::Overlay look_of_preview(const FlapSettings& shown);

}  // namespace trephine::bone_flap
