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

  /// Returns an error about the procedure or one of its steps ("step NAME: ..."), as volume::check() reports
  /// it, with the line of the step, or of the transition whose contents were found.
  Error at_line(Error error) const;
};

/// Parses and checks a procedure; `where` is its name in errors. Errors for unknown keys, wrong types and
/// impossible steps state the line. Names of commands, events and measurements are not checked.
Result<ProcedureFile> parse_procedure(const std::string& text, const std::string& where);
/// Reads and parses a file.
Result<ProcedureFile> read_procedure(const std::string& path);
/// Returns the contents of a file, with comments for users who edit it.
std::string procedure_text(const volume::SurgicalProcedure& procedure);
/// Returns a procedure of two steps to begin a new one with: a hole by a burr, and its end.
volume::SurgicalProcedure procedure_template(const std::string& name);

/// A procedure of this program.
struct ShippedProcedure {
  std::string_view name, text;  ///< contents of docs/procedures/NAME.toml
};
std::span<const ShippedProcedure> shipped_procedures() noexcept;
/// Returns their names as a list.
std::string shipped_names();
/// Returns a shipped procedure. Error: unknown name.
Result<ProcedureFile> shipped_procedure(const std::string& name);
/// True for the path of a file, which ends with ".toml"; else the name of a shipped procedure is meant.
bool is_procedure_path(const std::string& name_or_path);
/// Opens a shipped procedure by its name, or a file by its path.
Result<ProcedureFile> open_procedure(const std::string& name_or_path);

}  // namespace trephine::data_tools
