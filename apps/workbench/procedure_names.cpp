#include "apps/workbench/procedure_names.h"

#include <algorithm>
#include <string_view>

#include "apps/workbench/operation.h"
#include "modules/catalogue.h"
#include "sim/engine/procedure_check.h"

namespace trephine::workbench {

using volume::ProcedureStep;
using volume::StepTransition;
using volume::SurgicalProcedure;

namespace {

/// Measurements that every operation has, and the prefixes of measurements whose names contain another name:
/// "visits STEP".
constexpr std::string_view k_measurements[] = {"removed_mm3", "changes", "bodies", "step_seconds"};
constexpr std::string_view k_events = "events ", k_nearest = "nearest_mm ", k_visits = "visits ";

/// True unless every operation has this measurement: it is then a measure of a module, or misspelt.
bool is_module_measure(std::string_view name) {
  return std::find(std::begin(k_measurements), std::end(k_measurements), name) == std::end(k_measurements) &&
         !name.starts_with(k_events) && !name.starts_with(k_nearest) && !name.starts_with(k_visits);
}

}  // namespace

std::vector<sim::Measure> initial_measures(const sim::Module* module) {
  constexpr int k_size = 12;
  Result<volume::Volume> cube = volume::make_volume(glm::ivec3(k_size), {});
  if (!cube) return {};
  for (std::size_t i = 0; i < cube.value().voxels.size(); ++i)
    cube.value().voxels[i] = i < cube.value().voxels.size() / 2 ? 1000 : 0;
  Source source;
  source.volume = std::make_shared<const volume::Volume>(std::move(cube).value());
  OperationChoice choice;
  choice.shape.iso = 500;
  const Result<Operation> operation = make_operation(std::move(source), choice);
  if (!operation) return {};
  const sim::Engine engine = operation.value().engine();
  return module ? module->measures(engine.state()) : engine.measures();
}

Result<data_tools::ProcedureFile> open_known_procedure(const std::string& name_or_path) {
  Result<data_tools::ProcedureFile> file = data_tools::open_procedure(name_or_path);
  if (!file) return file.error();
  if (const Status error = sim::check_procedure(file.value().procedure, modules::catalogue()))
    return file.value().at_line(*error);
  return file;
}

Status choose_procedure(const OperationChoice& choice, sim::SceneDescription& spec) {
  volume::SurgicalProcedure& procedure = spec.plan.procedure;
  if (choice.procedure_use == ProcedureUse::ignored) procedure = {};
  if (choice.procedure.empty()) {
    if (Status error = sim::check_procedure(procedure, modules::catalogue())) return error;
  } else {
    Result<data_tools::ProcedureFile> file = open_known_procedure(choice.procedure);
    if (!file) return file.error();
    procedure = std::move(file).value().procedure;
  }
  if (choice.procedure_use == ProcedureUse::begins_without_tools && !procedure.is_empty())
    for (sim::HandSpec& hand : spec.hands) hand.instrument.clear(), hand.parameters.clear();
  return std::nullopt;
}

std::vector<std::string> late_measures_of(const SurgicalProcedure& procedure) {
  const std::vector<sim::Measure> known = initial_measures();
  std::vector<std::string> names;
  for (const ProcedureStep& step : procedure.steps)
    for (const StepTransition& transition : step.transitions)
      for (const auto& [name, minimum, maximum] : transition.conditions)
        if (is_module_measure(name) && std::find(names.begin(), names.end(), name) == names.end() &&
            std::none_of(known.begin(), known.end(), [&, &requested = name](const sim::Measure& measure) {
              return measure.name == requested;
            }))
          names.push_back(name);
  return names;
}

}  // namespace trephine::workbench
