// ProcedureFile: the steps of an operation, as a TOML file. docs/procedures.md describes every key.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "volume/base/error.h"
#include "volume/scan/procedure.h"

namespace trephine::data_tools {

/// A procedure that was read, with the line numbers of its steps and transitions.
struct ProcedureFile {
  static constexpr int k_schema = 1;
  struct StepLines {
    int line = 0;
    std::vector<int> transitions;
  };
  volume::SurgicalProcedure procedure;
  std::string where;             ///< name in errors
  std::vector<StepLines> lines;  ///< of the steps

  /// Adds a line to an error of volume::check(). The error is about the step in Error::where ("step NAME"),
  /// or else about the step whose name is Error::found. The line is that of the first transition of this step
  /// which contains Error::found, or else that of the step.
  Error at_line(Error error) const;
};

/// Parses and checks a procedure; `where` is its name in errors. Errors for unknown keys, wrong types and
/// impossible steps state the line. Names of commands, events and measurements are not checked.
Result<ProcedureFile> parse_procedure(const std::string& text, const std::string& where);
/// Reads and parses a file.
Result<ProcedureFile> read_procedure(const std::string& path);
/// Returns a procedure as the contents of a file, with comments for users who edit the file.
std::string procedure_text(const volume::SurgicalProcedure& procedure);
/// Returns a template for a new procedure. It has two steps: in the first, a hole is drilled with a burr; in
/// the second, the hole is complete.
volume::SurgicalProcedure procedure_template(const std::string& name);

/// A procedure that is part of the program.
struct ShippedProcedure {
  std::string_view name, text;  ///< contents of docs/procedures/NAME.toml
};
std::span<const ShippedProcedure> shipped_procedures() noexcept;
/// Returns the names of the shipped procedures, separated by commas.
std::string shipped_names();
/// Returns a shipped procedure. Error: unknown name.
Result<ProcedureFile> shipped_procedure(const std::string& name);
/// Returns true if the text ends with ".toml" and is therefore the path of a file; false for the name of a
/// shipped procedure.
bool is_procedure_path(const std::string& name_or_path);
/// Opens a shipped procedure by its name, or a file by its path.
Result<ProcedureFile> open_procedure(const std::string& name_or_path);

}  // namespace trephine::data_tools
