// Checks of a procedure against the instruments, commands, events and measurements of a program.
#pragma once

#include "sim/engine/engine.h"

namespace trephine::sim {

/// Parses an entry of ProcedureStep::on_entry, such as "cut-flap saw_width=1.6". The command is for the first
/// hand.
Result<Command> entry_command(const std::string& words, const Catalogue& catalogue);

/// Returns the first error of a procedure: an error of volume::check, an unknown instrument, command, event
/// or step, or a command on entry that its own step does not allow.
Status check_procedure(const volume::SurgicalProcedure& procedure, const Catalogue& catalogue);
/// Returns an error if the first step does not allow an instrument with which a hand (from 0 on) begins.
Status check_first_instrument(const volume::SurgicalProcedure& procedure, const Instrument& instrument,
                              std::size_t hand);
/// Returns an error if a condition depends on the distance to a structure that this engine lacks.
/// Measures of modules are not checked, since a module may add them later.
Status check_step_measurements(const volume::SurgicalProcedure& procedure, const Engine& engine,
                               const Catalogue& catalogue);

}  // namespace trephine::sim
