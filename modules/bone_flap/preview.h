// Job that previews a flap before it is cut, and the overlay of its result.
#pragma once

#include "modules/bone_flap/bone_flap.h"
#include "modules/bone_flap/judgement.h"
#include "modules/bone_flap/kerf.h"

namespace trephine::bone_flap {

inline constexpr const char* k_no_bone_to_cut = "there is no bone left along the outline";
inline SawLimits limits_of(const CutFlap& request) { return {request.hole, request.space, request.thickest}; }
/// Returns the first of these that exists: the points of the planned outline that the request names, the
/// anchors of the request, the drawn anchors, the points of the only outline of the plan.
template <class Request>
const std::vector<glm::dvec3>& anchors_of(const Request& request, const sim::OperationState& operation) {
  if (const volume::PlannedOutline* planned = find_outline(operation, request.outline))
    return planned->points_world;
  if (!request.anchors.empty()) return request.anchors;
  const std::vector<glm::dvec3>& drawn = operation.persistent_of<FlapSettings>()->anchors;
  const bool is_planned = drawn.empty() && operation.plan && operation.plan->outlines.size() == 1;
  return is_planned ? operation.plan->outlines[0].points_world : drawn;
}

const sim::JobType& preview_job();
/// Clears the preview.
void forget_preview(FlapPreview& preview);
/// Returns the overlay of a preview: the lid, and the walls below its rim.
sim::Overlay preview_overlay(const FlapPreview& preview);

}  // namespace trephine::bone_flap
