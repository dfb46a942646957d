// procedure: shows and checks procedures, and writes templates.
#include <filesystem>

#include "apps/cli/commands.h"
#include "apps/imaging/step_diagram.h"
#include "apps/view/step_picture.h"
#include "apps/workbench/procedure_names.h"
#include "data-tools/cases/procedure_file.h"
#include "data-tools/files/atomic_file.h"

namespace trephine::cli {

namespace {

using volume::ProcedureStep;
using volume::StepTransition;
using volume::SurgicalProcedure;

constexpr std::string_view k_actions[] = {"show", "check", "new"};

struct ProcedureArguments {
  std::string action, name, output;
};

std::string joined(const std::vector<std::string>& words) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : ", ") + word;
  return text;
}

Json transition_json(const StepTransition& transition) {
  Json json{{"to", transition.to}};
  if (!transition.on.empty()) json["on"] = transition.on;
  for (const volume::StepCondition& condition : transition.conditions) {
    Json one{{"measurement", condition.measurement}};
    if (condition.minimum) one["min"] = *condition.minimum;
    if (condition.maximum) one["max"] = *condition.maximum;
    json["when"].push_back(one);
  }
  return json;
}

/// Adds a step to the outcome, as text and JSON.
void report_step(const ProcedureStep& step, std::size_t number, Outcome& outcome) {
  Json row{{"name", step.name},
           {"title", step.title},
           {"hint", step.hint},
           {"note", step.note},
           {"instruments", step.instruments},
           {"commands", step.commands},
           {"on_entry", step.on_entry},
           {"is_end", step.is_end},
           {"transitions", Json::array()}};
  outcome.print("{number} {name}: {title}", {{"number", number}, {"name", step.name}, {"title", step.title}});
  const auto add = [&](const char* label, const std::string& text) {
    if (!text.empty()) outcome.print("    {label}{text}", {{"label", label}, {"text", text}});
  };
  add("", step.hint);
  add("instruments: ", joined(step.instruments));
  add("commands: ", joined(step.commands));
  add("on entry: ", joined(step.on_entry));
  for (const StepTransition& transition : step.transitions) {
    row["transitions"].push_back(transition_json(transition));
    add("-> ", transition.to + ": " + joined(imaging::words_of(transition)));
  }
  if (step.is_end) outcome.print("    end");
  outcome.json["steps"].push_back(row);
}

Outcome report_of(const SurgicalProcedure& procedure) {
  Outcome outcome("procedure");
  outcome.json["name"] = procedure.name;
  outcome.json["title"] = procedure.title;
  outcome.json["instruments"] = procedure.instruments;
  outcome.json["commands"] = procedure.commands;
  outcome.json["steps"] = Json::array();
  outcome.print("{name}: {title}");
  if (!procedure.instruments.empty()) outcome.print("every step: instruments {instruments}");
  if (!procedure.commands.empty()) outcome.print("every step: commands {commands}");
  for (std::size_t s = 0; s < procedure.steps.size(); ++s) report_step(procedure.steps[s], s + 1, outcome);
  return outcome;
}

Result<Outcome> show(const ProcedureArguments& a) {
  data_tools::OutputSet outputs;
  if (data_tools::is_procedure_path(a.name)) outputs.add_input(a.name);
  outputs.add_output("output", a.output);
  if (Status error = outputs.check()) return *error;
  const bool is_svg = data_tools::has_extension(a.output, ".svg");
  if (!a.output.empty() && !is_svg && !data_tools::has_extension(a.output, ".png"))
    return Error{.what = "unknown kind of picture",
                 .where = "--output",
                 .found = data_tools::file_name(a.output),
                 .expected = "a name that ends with .png or .svg"};
  const auto file = workbench::open_known_procedure(a.name);
  if (!file) return file.error();
  const imaging::StepDiagram diagram = imaging::step_diagram(file.value().procedure);
  outputs.write(a.output, [&] {
    return is_svg ? data_tools::write_file_atomically(a.output, imaging::svg_of(diagram))
                  : view::write_steps(diagram, a.output);
  });
  Outcome outcome = report_of(file.value().procedure);
  if (!a.output.empty()) outcome.text.clear();  // the picture replaces the text
  return finished(outputs, std::move(outcome));
}

Result<Outcome> check(const ProcedureArguments& a) {
  const auto file = workbench::open_known_procedure(a.name);
  if (!file) return file.error();
  const SurgicalProcedure& procedure = file.value().procedure;
  Outcome outcome("procedure");
  outcome.json["name"] = procedure.name;
  outcome.json["steps"] = procedure.steps.size();
  outcome.json["late_measures"] = workbench::late_measures_of(procedure);
  outcome.print("{name}: {steps} steps, no error");
  if (!outcome.json["late_measures"].empty())
    outcome.print("not measured at the start of an operation, check the spelling: {late_measures}");
  return outcome;
}

/// Writes a commented file of two steps.
Result<Outcome> begin(const ProcedureArguments& a) {
  data_tools::OutputSet outputs;
  outputs.add_output("output", a.output);
  if (Status error = outputs.check()) return *error;
  const SurgicalProcedure procedure = data_tools::procedure_template(a.name);
  if (Status error = volume::check(procedure)) return *error;
  if (data_tools::shipped_procedure(a.name))
    return Error{.what = "a procedure of this name is part of the program",
                 .where = "procedure",
                 .found = a.name,
                 .remedy = "choose another name"};
  if (std::error_code ignored; !a.output.empty() && std::filesystem::exists(a.output, ignored))
    return Error{.what = "the file already exists",
                 .where = "--output",
                 .found = data_tools::file_name(a.output),
                 .remedy = "choose another name, or delete the file"};
  outputs.write(a.output, [&] {
    return data_tools::write_file_atomically(a.output, data_tools::procedure_text(procedure));
  });
  Outcome outcome("procedure");
  outcome.json["name"] = procedure.name;
  if (a.output.empty()) outcome.text = data_tools::procedure_text(procedure);
  return finished(outputs, std::move(outcome));
}

Result<Outcome> run_procedure(const ProcedureArguments& a) {
  if (a.action == k_actions[0]) return show(a);
  return a.action == k_actions[1] ? check(a) : begin(a);
}

Run build_procedure(Options& options) {
  auto a = std::make_shared<ProcedureArguments>();
  options
      .add("ACTION", a->action,
           "show: print or draw the steps; check: look for errors; new: write a template")
      .required()
      .one_of({std::begin(k_actions), std::end(k_actions)});
  options
      .add("PROCEDURE", a->name,
           "A file, or the name of a shipped procedure: " + data_tools::shipped_names() +
               "; for new: the name of the new one")
      .required();
  options.add("-o,--output", a->output, "Write the drawing, or the template").type("PNG|SVG|TOML");
  options.add_modules();
  return run_with(a, run_procedure);
}

}  // namespace

const Command k_procedure{"procedure",
                          "Show or check a procedure (the steps of an operation), or write a template",
                          "  trephine procedure show craniotomy -o craniotomy.svg\n"
                          "  trephine procedure new my-procedure -o my-procedure.toml\n"
                          "  trephine procedure check my-procedure.toml",
                          build_procedure};

}  // namespace trephine::cli
