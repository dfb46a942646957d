// Overlays of a surgical plan: its trajectories, landmarks and outlines as lines and labels.
#pragma once

#include "sim/api/overlay.h"
#include "volume/scan/surgical_plan.h"

namespace trephine::workbench {

/// Returns the trajectories, landmarks and outlines of a plan as overlays; trajectories begin 20 mm before
/// their entry.
sim::Overlays plan_overlays(const volume::SurgicalPlan& plan);

}  // namespace trephine::workbench
