// modules: lists instruments, commands and events from the tables of the modules.
#include "apps/cli/commands.h"
#include "apps/workbench/procedure_names.h"
#include "apps/workbench/script.h"
#include "modules/catalogue.h"

namespace trephine::cli {

namespace {

struct ModulesArguments {
  std::string name;
};

/// Prints the field table of a struct, and returns it as JSON.
Json table_of(const sim::ValueType& type, const char* kind, Outcome& outcome) {
  const std::string name(type.schema->name);
  outcome.print("  {kind} {name}", {{"kind", kind}, {"name", name}});
  const sim::Value defaults = sim::Value::of(type);
  Json fields = Json::array();
  for (const sim::Field& field : type.schema->fields) {
    const std::string unit(field.info.unit), help(field.info.help), key(field.name);
    const std::string default_text = sim::to_words(field, defaults.data());
    Json row{{"name", key}, {"unit", unit}, {"default", default_text}, {"help", help}};
    std::string range;
    if (field.info.low > -1e300 || field.info.high < 1e300) {
      range = format_text("%.6g to %.6g", field.info.low, field.info.high);
      row["low"] = field.info.low, row["high"] = field.info.high;
    }
    for (const std::string_view choice : field.info.choices) {
      row["choices"].push_back(std::string(choice));
      range.append(range.empty() ? "" : ", ").append(choice);
    }
    fields.push_back(row);
    row["value"] = key + "=" + default_text, row["range"] = range;
    outcome.print(std::string("    {value:24} {unit}") + (unit.empty() || range.empty() ? "" : ", ") +
                      "{range}" + (help.empty() || (unit.empty() && range.empty()) ? "" : "; ") + "{help}",
                  row);
  }
  return {{"kind", kind}, {"name", name}, {"fields", fields}};
}

Result<Outcome> run_modules(const ModulesArguments& arguments) {
  Outcome outcome("modules");
  outcome.json["modules"] = Json::array();
  std::string names;
  bool is_found = arguments.name.empty();
  // Commands and events of the engine itself.
  if (arguments.name.empty() || arguments.name == "engine") {
    is_found = true;
    outcome.print("engine");
    Json parts = Json::array();
    const sim::Catalogue engine_types;
    for (const bool is_event : {false, true})
      for (const sim::ValueType* type : engine_types.all())
        if (engine_types.is_event(*type) == is_event && (is_event || engine_types.is_command(*type)))
          parts.push_back(table_of(*type, is_event ? "event" : "command", outcome));
    outcome.json["modules"].push_back({{"name", "engine"}, {"parts", parts}});
  }
  names = "engine";
  for (const sim::Module* module : modules::catalogue().modules()) {
    const std::string name(module->name());
    names.append(names.empty() ? "" : ", ").append(name);
    if (!arguments.name.empty() && name != arguments.name) continue;
    is_found = true;
    outcome.print("{name}", {{"name", name}});
    Json parts = Json::array();
    const auto add = [&](const sim::ValueType& type, const char* kind) {
      parts.push_back(table_of(type, kind, outcome));
    };
    for (const sim::InstrumentType* type : module->instruments()) add(*type->parameters, "instrument");
    for (const sim::ValueType* type : module->commands()) add(*type, "command");
    for (const sim::JobType* type : module->jobs()) add(*type->parameters, "job");
    for (const sim::ValueType* type : module->events()) add(*type, "event");
    Json measures = Json::array();
    for (const sim::Measure& one : workbench::initial_measures(module)) {
      measures.push_back({{"name", one.name}, {"unit", one.unit}});
      outcome.print("  measure {name}" + std::string(one.unit.empty() ? "" : ", {unit}"), measures.back());
    }
    outcome.json["modules"].push_back(
        {{"name", name}, {"version", module->version()}, {"parts", parts}, {"measures", measures}});
  }
  if (!is_found)
    return Error{.what = "unknown module",
                 .found = arguments.name,
                 .expected = names,
                 .remedy = "choose one of these"};
  return outcome;
}

Run build_modules(Options& options) {
  auto a = std::make_shared<ModulesArguments>();
  options.add("NAME", a->name, "Name of a module (default: all modules)");
  options.add_modules();
  return run_with(a, run_modules);
}

}  // namespace

const Command k_modules{"modules",
                        "List instruments, commands and events with their parameters, and measures",
                        "  trephine modules\n  trephine modules drilling --json", build_modules};

}  // namespace trephine::cli
