// ProcedureFile: the steps of an operation, as a TOML file. docs/procedures.md describes every key.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "volume/base/error.h"
#include "volume/scan/procedure.h"

namespace trephine::data_tools {

/// A procedure that was read, with the lines of its parts.
struct ProcedureFile {
  static constexpr int k_schema = 1;
  struct StepLines {
    int line = 0;
    std::vector<int> transitions;
  };
  volume::SurgicalProcedure procedure;
  std::string where;             ///< name in errors
  std::vector<StepLines> lines;  ///< of the steps

  /// Adds a line to an error of volume::check(): that of the step in Error::where ("step NAME"), or else of
  /// the step whose name is Error::found, or that of its transition which contains Error::found.
  Error at_line(Error error) const;
};

/// Parses and checks a procedure; `where` is its name in errors. Errors for unknown keys, wrong types and
/// impossible steps state the line. Names of commands, events and measurements are not checked.
Result<ProcedureFile> parse_procedure(const std::string& text, const std::string& where);
/// Reads and parses a file.
Result<ProcedureFile> read_procedure(const std::string& path);
/// Returns the contents of a file, with comments for users who edit it.
std::string procedure_text(const volume::SurgicalProcedure& procedure);
/// Returns a template for a new procedure, of two steps: a hole is drilled with a burr, and is complete.
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
/// Returns true for the path of a file, which ends with ".toml"; false for the name of a shipped procedure.
bool is_procedure_path(const std::string& name_or_path);
/// Opens a shipped procedure by its name, or a file by its path.
Result<ProcedureFile> open_procedure(const std::string& name_or_path);

}  // namespace trephine::data_tools
