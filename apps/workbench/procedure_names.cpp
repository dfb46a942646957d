#include "apps/workbench/procedure_names.h"

#include <algorithm>
#include <string_view>

#include "apps/workbench/operation.h"
#include "modules/catalogue.h"

namespace trephine::workbench {

using volume::ProcedureStep;
using volume::StepCondition;
using volume::StepTransition;
using volume::SurgicalProcedure;

namespace {

constexpr std::string_view k_all = "*";
/// Measurements of every operation, and prefixes of those that contain another name.
constexpr std::string_view k_measurements[] = {"removed_mm3", "strokes", "bodies", "step_seconds"};
constexpr std::string_view k_events = "events ", k_nearest = "nearest_mm ", k_visits = "visits ";

/// Splits "burr diameter=4" into a name and the words behind it.
std::pair<std::string_view, std::string_view> split(std::string_view words) {
  const std::size_t space = words.find(' ');
  return space == std::string_view::npos ? std::pair(words, std::string_view())
                                         : std::pair(words.substr(0, space), words.substr(space + 1));
}

/// Returns the names of all types for which is_one(type) holds, as text.
template <class IsOne>
std::string names_of(const IsOne& is_one) {
  std::string names;
  for (const sim::ValueType* type : modules::catalogue().all())
    if (is_one(*type)) names.append(names.empty() ? "" : ", ").append(type->schema->name);
  return names;
}

bool is_event(const sim::ValueType& type) { return modules::catalogue().is_event(type); }
bool is_command(const sim::ValueType& type) { return modules::catalogue().is_command(type); }

Error unknown(const char* what, std::string_view found, std::string expected) {
  return {.what = std::string("unknown ") + what,
          .found = std::string(found),
          .expected = std::move(expected),
          .remedy = "correct the spelling"};
}

Status check_instrument(const std::string& entry) {
  if (entry == k_all) return std::nullopt;
  const auto [name, words] = split(entry);
  const sim::InstrumentType* instrument = modules::catalogue().find_instrument(name);
  if (instrument == nullptr)
    return unknown("instrument", name, names_of([](const sim::ValueType& type) {
                     return modules::catalogue().find_instrument(type.schema->name) != nullptr;
                   }));
  Status error = sim::Value::of(*instrument->parameters).set(words);
  if (error) error->found = entry;
  return error;
}

Status check_command(const std::string& name) {
  if (name == k_all) return std::nullopt;
  const sim::ValueType* type = modules::catalogue().find(name);
  if (type && is_command(*type)) return std::nullopt;
  return unknown("command", name, names_of(is_command));
}

Status check_entry_command(const std::string& words) {
  const auto [name, parameters] = split(words);
  if (Status error = check_command(std::string(name))) return error;
  const auto command = modules::catalogue().command(name, parameters);
  Status error = command ? command.value().request.check() : Status(command.error());
  if (error) error->found = words;
  return error;
}

Status check_cause(const std::string& name) {
  if (name.empty() || name == StepTransition::k_on_request) return std::nullopt;
  const sim::ValueType* type = modules::catalogue().find(name);
  if (type && (is_command(*type) || is_event(*type))) return std::nullopt;
  return unknown("cause of a transition", name,
                 std::string(StepTransition::k_on_request) + ", a command or an event: " +
                     names_of([](const sim::ValueType& one) { return is_event(one); }));
}

/// True for measures of modules.
bool is_module_measure(std::string_view name) {
  return std::find(std::begin(k_measurements), std::end(k_measurements), name) == std::end(k_measurements) &&
         !name.starts_with(k_events) && !name.starts_with(k_nearest) && !name.starts_with(k_visits);
}

Status check_measurement(const std::string& name, const SurgicalProcedure& procedure) {
  Status error;
  if (name.starts_with(k_events)) {
    const sim::ValueType* type = modules::catalogue().find(name.substr(k_events.size()));
    if (!type || !is_event(*type)) error = unknown("event", name, names_of(is_event));
  } else if (name.starts_with(k_visits) && procedure.find(name.substr(k_visits.size())) < 0) {
    error = unknown("step", name, "the name of a step of this procedure");
  }
  return error;
}

Status check_step(const ProcedureStep& step, const SurgicalProcedure& procedure) {
  for (const std::string& entry : step.instruments)
    if (Status error = check_instrument(entry)) return error;
  for (const std::string& name : step.commands)
    if (Status error = check_command(name)) return error;
  for (const std::string& words : step.on_entry)
    if (Status error = check_entry_command(words)) return error;
  for (const StepTransition& transition : step.transitions) {
    if (Status error = check_cause(transition.on)) return error;
    for (const StepCondition& condition : transition.conditions)
      if (Status error = check_measurement(condition.measurement, procedure)) return error;
  }
  return std::nullopt;
}

/// Returns the measures of an operation on a small cube before its first command.
std::vector<sim::Measure> new_measures() {
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
  return operation ? operation.value().engine().measures() : std::vector<sim::Measure>();
}

}  // namespace

Status check_names(const SurgicalProcedure& procedure) {
  // Lists of the procedure are checked like a step of its own.
  ProcedureStep common;
  common.instruments = procedure.instruments, common.commands = procedure.commands;
  if (Status error = check_step(common, procedure)) {
    error->where = "procedure";
    return error;
  }
  for (const ProcedureStep& step : procedure.steps)
    if (Status error = check_step(step, procedure)) {
      error->where = "step " + step.name;
      return error;
    }
  return std::nullopt;
}

Result<data_tools::ProcedureFile> open_known_procedure(const std::string& name_or_path) {
  Result<data_tools::ProcedureFile> file = data_tools::open_procedure(name_or_path);
  if (!file) return file.error();
  if (const Status error = check_names(file.value().procedure)) return file.value().at_line(*error);
  return file;
}

Status choose_procedure(const OperationChoice& choice, sim::SceneDescription& spec) {
  volume::SurgicalProcedure& procedure = spec.plan.procedure;
  if (choice.procedure_use == ProcedureUse::ignored) procedure = {};
  if (choice.procedure.empty()) {
    if (Status error = check_names(procedure)) return error;
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
  const std::vector<sim::Measure> known = new_measures();
  std::vector<std::string> names;
  for (const ProcedureStep& step : procedure.steps)
    for (const StepTransition& transition : step.transitions)
      for (const auto& [name, minimum, maximum] : transition.conditions)
        if (is_module_measure(name) && std::find(names.begin(), names.end(), name) == names.end() &&
            std::none_of(known.begin(), known.end(),
                         [&](const sim::Measure& measure) { return measure.name == name; }))
          names.push_back(name);
  return names;
}

}  // namespace trephine::workbench
