// Rules of a procedure: the instruments and commands that a step allows, and texts about them.
#pragma once

#include <string>

#include "sim/api/catalogue.h"
#include "volume/scan/procedure.h"

namespace trephine::sim {

/// Entry of a list that allows all instruments, or all commands except those with StepRule::named.
inline constexpr const char* k_any = "*";

/// First word of a text, and the rest.
struct NamedWords {
  std::string_view name, words;
};
NamedWords split_name(std::string_view text) noexcept;

/// Returns an error unless the step or its procedure allows the instrument. Entries of their lists are "*",
/// or a name with required values of parameters: "burr kinematic=no removal_rate=0". An empty hand is always
/// allowed.
Status check_instrument(const volume::SurgicalProcedure& procedure, const volume::ProcedureStep& step,
                        const Instrument& instrument);
/// Returns an error unless the step or its procedure allows commands of this type. Not for commands that set
/// the parameters of an instrument: check these with check_instrument().
Status check_command(const volume::SurgicalProcedure& procedure, const volume::ProcedureStep& step,
                     const ValueType& type);
/// Returns an error unless a transition on request leads from `step` to the step `name`.
Status check_has_request(const volume::ProcedureStep& step, const std::string& name);

/// Returns the name by which StepRefused refers to a command: that of the requested step or of the instrument
/// to take; for other commands, that of the command.
std::string request_name(const Command& command);

/// Returns the condition in words, such as "removed_mm3 at least 100 and at most 200".
std::string words_of(const volume::StepCondition& condition);
/// Returns the names with commas, such as "burr, perforator"; `none` if the list is empty.
std::string joined_names(const std::vector<std::string>& names, const char* none);

}  // namespace trephine::sim
