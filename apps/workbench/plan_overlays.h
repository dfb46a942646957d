// Overlays of a surgical plan: its trajectories, landmarks and outlines as lines and labels.
#pragma once

#include "haptics/scene/touch_scene.h"
#include "sim/api/overlay.h"
#include "volume/scan/surgical_plan.h"

namespace trephine::workbench {

/// Returns the trajectories, landmarks and outlines of a plan as overlays. The line of a trajectory
/// begins 20 mm outside its entry. Rings at entries lie on the uncut bone of the scene.
sim::Overlays plan_overlays(const volume::SurgicalPlan& plan, const haptics::TouchScene& scene);

}  // namespace trephine::workbench
