// A script is played without threads: hands go their ways, commands are told, expectations are checked.
#pragma once

#include "apps/workbench/sessions.h"
#include "data-tools/script_file.h"
#include "sim/lockstep.h"

namespace trephine::workbench {

/// Something that was to be so, and whether it was.
struct ScriptCheck {
  int line = 0;      ///< of the script
  std::string what;  ///< "removed_mm3 >= 100", or a command
  double at = 0;     ///< s
  bool is_met = false;
  std::string found;  ///< in words
};

struct ScriptReport {
  std::vector<ScriptCheck> checks;
  std::uint64_t ticks = 0;
  double seconds = 0;  ///< of the operation
  double strongest_force_n = 0;
  std::vector<double> strongest_of;  ///< N, each hand
  volume::Status recording;          ///< how it ended, when it ended badly
  bool is_met() const;
};

/// May a script tell it? Not what keeps an engine's books.
bool may_be_told(const sim::ValueType& type);
/// What can be expected beside the measures of modules.
std::vector<std::string> expectable();

/// The scan and the paths that a script names, as the program sees them.
std::vector<std::string> files_of(const data_tools::Script& script, const std::string& folder);

/// A script with its scan open and its hands made ready.
class ScriptRun {
 public:
  /// `folder`: from where the script sees its files. Errors name the script's line.
  static volume::Result<std::unique_ptr<ScriptRun>> open(const data_tools::Script& script,
                                                         const std::string& folder, const std::string& where,
                                                         const Listener& listener = {});
  const Operation& operation() const { return operation_; }
  /// Plays all of it, once. `recorder`: may be null; it is finished.
  volume::Result<ScriptReport> play(sim::SessionWriter* recorder, const Listener& listener = {});
  /// As it ended.
  const sim::Engine& engine() const { return run_->engine(); }

 private:
  struct Told {
    const data_tools::ScriptCommand* from;
    sim::Command command;
  };
  ScriptRun(const data_tools::Script& script, Operation operation)
      : script_(script), operation_(std::move(operation)) {}
  volume::Status check_names(const std::string& where) const;
  void tell(const Told& told, double t, ScriptReport& report);
  std::optional<double> value_of(const std::string& what, int hand, const ScriptReport& report) const;

  data_tools::Script script_;
  Operation operation_;
  std::vector<haptics::PosePath> paths_;
  std::vector<Told> told_;
  std::optional<sim::Lockstep> run_;
};

}  // namespace trephine::workbench
