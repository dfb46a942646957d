// Names in a procedure: commands, instruments, events and measurements, compared with the catalogue.
#pragma once

#include <string>
#include <vector>

#include "data-tools/cases/procedure_file.h"
#include "volume/base/error.h"
#include "volume/scan/procedure.h"

namespace trephine::workbench {

/// Returns an error if a step names an unknown command, instrument, event or step, or parameters that an
/// instrument or a command does not have. `where` is "procedure" or "step NAME", and `found` the name.
/// Measures of modules exist only while an operation runs: they are not checked.
Status check_names(const volume::SurgicalProcedure& procedure);
/// Opens a shipped procedure by its name, or a file by its path, and checks its names. Errors state the line.
Result<data_tools::ProcedureFile> open_known_procedure(const std::string& name_or_path);
/// Returns the names of the measures of modules that conditions require, without duplicates.
std::vector<std::string> module_measures_of(const volume::SurgicalProcedure& procedure);

}  // namespace trephine::workbench
