// Sentences about the steps of a procedure, for users.
#pragma once

#include <optional>
#include <string>

#include "volume/scan/procedure.h"

namespace trephine::workbench {

/// Describes an unmet condition: "At least 3 strokes are needed; there are 2." `value`: value of the
/// measurement; nullopt: unknown.
std::string describe_unmet(const volume::StepCondition& condition, const std::optional<double>& value);

/// Describes why the step `next` cannot be requested, in one sentence per reason. An instrument that the step
/// does not allow is reported only if all conditions are met. `error`: refusal of the command go-to-step in
/// the step `current`.
std::string describe_refusal(const volume::ProcedureStep& current, const std::string& next,
                             const Error& error);

/// Describes why a step does not allow an instrument or a command (`subject`): "The step \"Judge\" does not
/// allow this instrument. It allows: burr, perforator." `error`: of sim::check_instrument() or
/// sim::check_command().
std::string describe_prohibition(const volume::ProcedureStep& step, const char* subject, const Error& error);

}  // namespace trephine::workbench
