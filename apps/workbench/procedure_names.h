// Procedure of an operation: its choice, and its names, compared with the catalogue.
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

/// Opens a shipped procedure by its name, or a file by its path, and checks its names. Errors state the line.
Result<data_tools::ProcedureFile> open_known_procedure(const std::string& name_or_path);
/// Sets the chosen procedure in the plan of a scene, checks its names, and prepares the hands.
Status choose_procedure(const OperationChoice& choice, sim::SceneDescription& spec);
/// Returns the measures of an operation on a small cube before its first command; of one module, or of all.
std::vector<sim::Measure> initial_measures(const sim::Module* module = nullptr);
/// Returns the names of the measurements of conditions that a new operation does not have: measures that a
/// module returns later, or misspelt names. Builds a small operation.
std::vector<std::string> late_measures_of(const volume::SurgicalProcedure& procedure);

}  // namespace trephine::workbench
