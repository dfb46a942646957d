// Job that previews a flap before it is cut, and the overlay of its result.
#pragma once

#include "modules/bone_flap/bone_flap.h"
#include "modules/bone_flap/kerf.h"

namespace trephine::bone_flap {

inline SawLimits limits_of(const CutFlap& request) { return {request.hole, request.space, request.thickest}; }
/// Returns the anchors of a request, or the drawn anchors if it has no anchors.
template <class Request>
const std::vector<glm::dvec3>& anchors_of(const Request& request, const FlapSettings& settings) {
  return request.anchors.empty() ? settings.anchors : request.anchors;
}

const sim::JobType& preview_job();
/// Clears the preview.
void forget_preview(FlapPreview& preview);
/// Returns the overlay of a preview: the lid, and the walls below its rim.
sim::Overlay preview_overlay(const FlapPreview& preview);

}  // namespace trephine::bone_flap
