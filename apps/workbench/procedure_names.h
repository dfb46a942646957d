// Choice of the procedure of an operation. The names in the procedure are checked against the catalogue of
// modules.
#pragma once

#include <string>
#include <vector>

#include "data-tools/cases/procedure_file.h"
#include "volume/base/error.h"
#include "volume/scan/procedure.h"

namespace trephine::sim {
class Module;
struct Measure;
struct SceneDescription;
}  // namespace trephine::sim

namespace trephine::workbench {

struct OperationChoice;

/// Opens a shipped procedure by its name, or a file by its path, and checks the names in the procedure.
/// Errors state the line.
Result<data_tools::ProcedureFile> open_known_procedure(const std::string& name_or_path);
/// Sets the chosen procedure in the plan of a scene, and checks the names in it. Removes the instruments of
/// the hands if ProcedureUse::begins_without_tools is chosen.
Status choose_procedure(const OperationChoice& choice, sim::SceneDescription& spec);
/// Returns the measures of one module, or of all modules if `module` is null, in an operation on a small cube
/// before its first command.
std::vector<sim::Measure> initial_measures(const sim::Module* module = nullptr);
/// Returns the names of measures that conditions of the procedure use and a new operation lacks: a module
/// returns them only later, or they are misspelt. Builds a small operation.
std::vector<std::string> late_measures_of(const volume::SurgicalProcedure& procedure);

}  // namespace trephine::workbench
