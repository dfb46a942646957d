// Findings of an operation: those of its modules, and those about the procedure, forbidden structures,
// refused requests, undo, time and motion.
#pragma once

#include <functional>
#include <vector>

#include "apps/workbench/motion_stats.h"
#include "sim/engine/engine.h"

namespace trephine::workbench {

/// Returns the findings of all modules and those of operation_findings(), with unique names. Freezes the
/// engine; takes seconds. `motion` may be null. `progress` is called with the completed share before each
/// module; if it returns false, the remaining modules are left out.
std::vector<sim::Finding> findings_of(
    sim::Engine& engine, const MotionStats* motion,
    const std::function<bool(double share)>& progress = [](double) { return true; });

/// Returns the score of findings_of() and of the `additional` findings. Limits of the plan and of its
/// procedure replace the usual limits of the findings that they name.
sim::Score score_of(
    sim::Engine& engine, const MotionStats* motion,
    const std::function<bool(double share)>& progress = [](double) { return true; },
    std::vector<sim::Finding> additional = {});

/// Returns the findings about the procedure, forbidden structures, refused requests, undo, time and motion.
/// `motion` may be null.
std::vector<sim::Finding> operation_findings(const sim::OperationState& operation,
                                             std::span<const std::shared_ptr<const sim::Forbidden>> forbidden,
                                             const MotionStats* motion);

}  // namespace trephine::workbench
