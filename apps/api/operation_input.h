// Options and data of an Operation, checked, and converted to those of the workbench.
#pragma once

#include "apps/api/operation.h"
#include "apps/workbench/operation.h"
#include "apps/workbench/sessions.h"

namespace trephine {

workbench::OperationChoice choice_of(const OperationOptions& options);
workbench::RecordChoice record_of(const Recording& recording);

/// Error if the number of hands is out of range.
Status check(const OperationOptions& options);
/// Checks a model of open_scene(). `number`: its index, from 0, for messages.
Status check(const Surface& surface, std::size_t number);
bool has_volumes(std::span<const std::shared_ptr<const Volume>> volumes);
Error missing_volume();

}  // namespace trephine
