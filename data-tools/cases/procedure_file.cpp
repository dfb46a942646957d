#include "data-tools/cases/procedure_file.h"

#include <algorithm>

#include "data-tools/cases/score_toml.h"
#include "data-tools/cases/shipped_procedures.h"
#include "data-tools/cases/toml_reader_impl.h"
#include "data-tools/files/atomic_file.h"

namespace trephine::data_tools {

using volume::ProcedureStep;
using volume::StepCondition;
using volume::StepTransition;
using volume::SurgicalProcedure;

namespace {

constexpr double k_largest = 1e12;                   // largest min or max of a condition
constexpr std::size_t k_longest_hint = 2000;         // characters of a hint or a note
constexpr std::string_view k_step_prefix = "step ";  // start of the location in errors of volume::check()

StepCondition read_condition(TomlReader& reader, const toml::value& value) {
  const toml::table& t = reader.table(value, {"measurement", "min", "max"});
  StepCondition condition;
  condition.measurement = reader.text(t, "measurement").value_or("");
  condition.minimum = reader.number(t, "min", -k_largest, k_largest);
  condition.maximum = reader.number(t, "max", -k_largest, k_largest);
  if (condition.measurement.empty() || !(condition.minimum || condition.maximum))
    reader.fail(value, "a condition is not complete", condition.measurement,
                "{measurement = \"name\", min = number}, or max, or both");
  if (condition.minimum && condition.maximum && *condition.minimum > *condition.maximum)
    reader.fail(value, "the limits of a condition are reversed", condition.measurement, "min <= max",
                "swap the two values");
  return condition;
}

StepTransition read_transition(TomlReader& reader, const toml::value& value) {
  const toml::table& t = reader.table(value, {"to", "on", "when"});
  StepTransition transition;
  transition.to = reader.text(t, "to").value_or("");
  transition.on = reader.text(t, "on").value_or("");
  for (const toml::value* v : reader.tables(t, "when"))
    transition.conditions.push_back(read_condition(reader, *v));
  if (transition.to.empty())
    reader.fail(value, "a transition has no destination", "", "to = \"the name of a step\"");
  if (transition.on.empty() && transition.conditions.empty())
    reader.fail(
        value, "a transition has no cause", transition.to,
        "on = \"a command, an event or request\", or when = [{measurement = \"name\", min = number}]");
  return transition;
}

ProcedureStep read_step(TomlReader& reader, const toml::value& value, ProcedureFile::StepLines& lines) {
  const toml::table& t = reader.table(
      value, {"name", "title", "hint", "note", "instruments", "commands", "on_entry", "end", "transitions"});
  lines.line = TomlReader::line_of(value);
  ProcedureStep step;
  step.name = reader.text(t, "name").value_or("");
  if (step.name.empty()) reader.fail(value, "a step has no name", "", "name = \"remove-bone\"");
  step.title = reader.text(t, "title").value_or("");
  step.hint = reader.text(t, "hint", k_longest_hint).value_or("");
  step.note = reader.text(t, "note", k_longest_hint).value_or("");
  step.instruments = reader.texts(t, "instruments");
  step.commands = reader.texts(t, "commands");
  step.on_entry = reader.texts(t, "on_entry");
  step.is_end = reader.boolean(t, "end").value_or(false);
  for (const toml::value* v : reader.tables(t, "transitions")) {
    step.transitions.push_back(read_transition(reader, *v));
    lines.transitions.push_back(TomlReader::line_of(*v));
  }
  return step;
}

/// Returns true if `found` (of an error about a step) is the destination, the cause or a measurement of this
/// transition.
bool is_about(const StepTransition& transition, const std::string& found) {
  const auto has_name = [&](const StepCondition& condition) { return condition.measurement == found; };
  return transition.to == found || (!found.empty() && transition.on == found) ||
         std::any_of(transition.conditions.begin(), transition.conditions.end(), has_name);
}

std::string list_text(const std::vector<std::string>& list) {
  std::string text;
  for (const std::string& item : list) text += (text.empty() ? "" : ", ") + toml_text(item);
  return "[" + text + "]";
}

std::string condition_text(const StepCondition& condition) {
  std::string text = "{measurement = " + toml_text(condition.measurement);
  if (condition.minimum) text += ", min = " + text_of(*condition.minimum);
  if (condition.maximum) text += ", max = " + text_of(*condition.maximum);
  return text + "}";
}

/// Writes lines of TOML. If a comment is repeated, only its first occurrence is written.
class Writer {
 public:
  void comment(const std::string& text) {
    if (std::find(comments_.begin(), comments_.end(), text) != comments_.end()) return;
    comments_.push_back(text);
    text_ += "# " + text + "\n";
  }
  void line(const char* key, const std::string& value) { text_ += std::string(key) + " = " + value + "\n"; }
  void text(const char* key, const std::string& value) {
    if (!value.empty()) line(key, toml_text(value));
  }
  void list(const char* key, const std::vector<std::string>& value) {
    if (!value.empty()) line(key, list_text(value));
  }
  void table(const char* name) { text_ += "\n[[" + std::string(name) + "]]\n"; }
  const std::string& all() const { return text_; }

 private:
  std::string text_;
  std::vector<std::string> comments_;
};

void write_transition(Writer& out, const StepTransition& transition) {
  out.table("steps.transitions");
  out.comment("The first transition whose cause and conditions hold is taken.");
  out.text("to", transition.to);
  if (!transition.on.empty()) {
    out.comment(
        "Cause: a command, an event, or \"request\" (the user's command go-to-step). "
        "Without \"on\", any of these, or the end of a stroke.");
    out.text("on", transition.on);
  }
  std::string conditions;
  for (const StepCondition& condition : transition.conditions)
    conditions += (conditions.empty() ? "" : ", ") + condition_text(condition);
  if (conditions.empty()) return;
  out.comment("Measurements with a min, a max or both; all must be met.");
  out.line("when", "[" + conditions + "]");
}

void write_step(Writer& out, const ProcedureStep& step) {
  out.table("steps");
  out.text("name", step.name);
  out.text("title", step.title);
  if (!step.hint.empty()) out.comment("Instruction for the user.");
  out.text("hint", step.hint);
  if (!step.note.empty()) out.comment("Explanation to learn from.");
  out.text("note", step.note);
  if (!step.instruments.empty() || !step.commands.empty())
    out.comment("Allowed in this step. An instrument may be followed by parameters that it must have.");
  out.list("instruments", step.instruments);
  out.list("commands", step.commands);
  if (!step.on_entry.empty()) out.comment("Commands that are issued when the step begins.");
  out.list("on_entry", step.on_entry);
  if (step.is_end) out.comment("The operation is complete.");
  if (step.is_end) out.line("end", "true");
  for (const StepTransition& transition : step.transitions) write_transition(out, transition);
}

}  // namespace

Error ProcedureFile::at_line(Error error) const {
  std::string step;  // the name after "step ", up to a comma or a colon
  if (error.where.starts_with(k_step_prefix))
    step = error.where.substr(k_step_prefix.size(), error.where.find_first_of(",:") - k_step_prefix.size());
  int line = 0;
  for (std::size_t s = 0; s < procedure.steps.size(); ++s) {
    // An error about an invalid name contains this name only in `found`.
    if (procedure.steps[s].name != (step.empty() ? error.found : step)) continue;
    line = lines[s].line;
    const auto& transitions = procedure.steps[s].transitions;
    for (std::size_t i = 0; i < transitions.size(); ++i)
      if (is_about(transitions[i], error.found)) {
        line = lines[s].transitions[i];
        break;
      }
  }
  error.where =
      where + (line > 0 ? ", line " + std::to_string(line) : "") + (step.empty() ? "" : ": " + error.where);
  return error;
}

Result<ProcedureFile> parse_procedure(const std::string& text, const std::string& where) {
  const Result<toml::value> parsed = parse_toml(text, where, "procedure");
  if (!parsed) return parsed.error();
  const toml::value& root = parsed.value();
  TomlReader reader(where);
  const toml::table& top =
      reader.table(root, {"schema", "name", "title", "instruments", "commands", "steps", "score"});
  if (Status error = reader.check_schema(top, ProcedureFile::k_schema, "procedure")) return *error;
  ProcedureFile file;
  file.where = where;
  SurgicalProcedure& procedure = file.procedure;
  procedure.name = reader.text(top, "name").value_or("");
  if (procedure.name.empty()) reader.fail(root, "the procedure has no name", "", "name = \"craniotomy\"");
  procedure.title = reader.text(top, "title").value_or("");
  procedure.instruments = reader.texts(top, "instruments");
  procedure.commands = reader.texts(top, "commands");
  for (const toml::value* v : reader.tables(top, "steps"))
    procedure.steps.push_back(read_step(reader, *v, file.lines.emplace_back()));
  procedure.score = read_score(reader, top);
  if (procedure.steps.empty()) reader.fail(root, "the procedure has no step", "", "at least one [[steps]]");
  if (reader.error()) return *reader.error();
  if (const Status error = volume::check(procedure)) return file.at_line(*error);
  return file;
}

Result<ProcedureFile> read_procedure(const std::string& path) {
  const std::string where = file_name(path);
  const Result<std::string> text = read_toml_text(path, where, "procedure");
  return text ? parse_procedure(text.value(), where) : text.error();
}

std::string procedure_text(const SurgicalProcedure& procedure) {
  Writer out;
  out.comment("A procedure of trephine. Every key is described in docs/procedures.md.");
  out.line("schema", std::to_string(ProcedureFile::k_schema));
  out.text("name", procedure.name);
  out.text("title", procedure.title);
  if (!procedure.instruments.empty() || !procedure.commands.empty())
    out.comment("Allowed in every step, in addition to undo, redo, branches and notes.");
  out.list("instruments", procedure.instruments);
  out.list("commands", procedure.commands);
  for (const ProcedureStep& step : procedure.steps) write_step(out, step);
  return out.all() + score_text(procedure.score);
}

SurgicalProcedure procedure_template(const std::string& name) {
  SurgicalProcedure procedure;
  procedure.name = name, procedure.title = "A burr hole";
  procedure.commands = {"look-at", "measure"};
  procedure.steps.resize(2);
  ProcedureStep &drill = procedure.steps[0], &done = procedure.steps[1];
  drill.name = "drill", drill.title = "Drill the hole";
  drill.hint = "Press the burr on the skull until the hole is through.";
  drill.note = "A burr that sweeps without contact (kinematic) is not allowed here.";
  drill.instruments = {"burr kinematic=no"};
  drill.transitions = {{"done", StepTransition::k_on_request, {{"removed_mm3", 100, {}}}}};
  done.name = "done", done.title = "The hole is complete";
  done.on_entry = {"note text=\"the hole is complete\""};
  done.is_end = true;
  return procedure;
}

std::span<const ShippedProcedure> shipped_procedures() noexcept { return k_shipped_procedures; }

std::string shipped_names() {
  std::string names;
  for (const ShippedProcedure& shipped : k_shipped_procedures)
    names.append(names.empty() ? "" : ", ").append(shipped.name);
  return names;
}

Result<ProcedureFile> shipped_procedure(const std::string& name) {
  for (const ShippedProcedure& shipped : k_shipped_procedures)
    if (shipped.name == name) return parse_procedure(std::string(shipped.text), name + ".toml");
  return Error{.what = "unknown procedure",
               .where = "procedure",
               .found = name,
               .expected = shipped_names(),
               .remedy = "choose one of these, or a file NAME.toml"};
}

bool is_procedure_path(const std::string& name_or_path) { return has_extension(name_or_path, ".toml"); }

Result<ProcedureFile> open_procedure(const std::string& name_or_path) {
  return is_procedure_path(name_or_path) ? read_procedure(name_or_path) : shipped_procedure(name_or_path);
}

}  // namespace trephine::data_tools
