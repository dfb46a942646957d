// modules: instruments, commands and events, from the tables of the modules.
#include "apps/trephine/commands.h"
#include "apps/workbench/script.h"
#include "modules/catalogue.h"

namespace trephine::app {

using volume::Result;

namespace {

struct ModulesArguments {
  std::string name;
};

/// The table of a struct, as words and as JSON.
Json table_of(const sim::ValueType& type, const char* kind, std::string& text) {
  const std::string name(type.schema->name);
  text += format_text("  %s %s\n", kind, name.c_str());
  const sim::Value usual = sim::Value::of(type);
  Json fields = Json::array();
  for (const sim::Field& field : type.schema->fields) {
    const std::string unit(field.info.unit), help(field.info.help), key(field.name);
    const std::string given = sim::to_words(field, usual.data());
    Json row{{"name", key}, {"unit", unit}, {"default", given}, {"help", help}};
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
    const std::string value = key + "=" + given;
    text += format_text("    %-24s %s%s%s%s%s\n", value.c_str(), unit.c_str(),
                        unit.empty() || range.empty() ? "" : ", ", range.c_str(),
                        help.empty() || (unit.empty() && range.empty()) ? "" : "; ", help.c_str());
  }
  return {{"kind", kind}, {"name", name}, {"fields", fields}};
}

Result<Outcome> run_modules(const ModulesArguments& arguments) {
  Outcome outcome{new_report("modules"), "", exit_done};
  outcome.json["modules"] = Json::array();
  std::string known;
  bool is_found = arguments.name.empty();
  // Commands and events that exist whatever the modules are.
  if (arguments.name.empty() || arguments.name == "engine") {
    is_found = true;
    outcome.text += "engine\n";
    Json parts = Json::array();
    const sim::Catalogue own;
    for (const bool is_event : {false, true})
      for (const sim::ValueType* type : own.all())
        if (own.is_event(*type) == is_event && (is_event || own.is_command(*type)))
          parts.push_back(table_of(*type, is_event ? "event" : "command", outcome.text));
    outcome.json["modules"].push_back({{"name", "engine"}, {"parts", parts}});
  }
  known = "engine";
  for (const sim::Module* module : modules::catalogue().modules()) {
    const std::string name(module->name());
    known.append(known.empty() ? "" : ", ").append(name);
    if (!arguments.name.empty() && name != arguments.name) continue;
    is_found = true;
    outcome.text += name + "\n";
    Json parts = Json::array();
    const auto add = [&](const sim::ValueType& type, const char* kind) {
      parts.push_back(table_of(type, kind, outcome.text));
    };
    for (const sim::InstrumentType* one : module->instruments()) add(*one->parameters, "instrument");
    for (const sim::ValueType* one : module->commands()) add(*one, "command");
    for (const sim::JobType* one : module->jobs()) add(*one->parameters, "job");
    for (const sim::ValueType* one : module->events()) add(*one, "event");
    outcome.json["modules"].push_back({{"name", name}, {"version", module->version()}, {"parts", parts}});
  }
  if (!is_found)
    return volume::Error{"there is no such module", "", arguments.name, known, "choose one of these"};
  return outcome;
}

Run build(Options& options) {
  auto a = std::make_shared<ModulesArguments>();
  options.add("NAME", a->name, "One of them; all when left out");
  return run_with(a, run_modules);
}

}  // namespace

const Command k_modules{"modules", "List instruments, commands and events with their parameters",
                        "  trephine modules\n  trephine modules drilling --json", build};

}  // namespace trephine::app
