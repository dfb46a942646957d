// SurgicalProcedure: the steps of an operation, with the instruments and commands that each step allows and
// the transitions between steps.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "volume/base/error.h"

namespace trephine::volume {

/// Limits of a measurement. An unknown measurement, or a stale one (after a change of the anatomy), meets no
/// limits.
struct StepCondition {
  std::string measurement;  ///< such as "removed_mm3", "events flap-cut" or a measure of a module
  std::optional<double> minimum, maximum;
  friend bool operator==(const StepCondition&, const StepCondition&) = default;
};

/// Change from one step to another.
struct StepTransition {
  static constexpr const char* k_on_request = "request";
  std::string to;  ///< name of the next step
  /// Name of the command or event that causes the transition, or k_on_request: the command go-to-step causes
  /// it. Empty: any command, event or end of a stroke.
  std::string on;
  std::vector<StepCondition> conditions;  ///< all must be met
  friend bool operator==(const StepTransition&, const StepTransition&) = default;
};

struct ProcedureStep {
  std::string name;   ///< "remove-bone"; unique
  std::string title;  ///< in the user's words
  std::string hint;   ///< instruction for the user; may be empty
  std::string note;   ///< explanation to learn from; may be empty
  /// Names of instruments and commands that the step allows in addition to those of the procedure; "*": all.
  std::vector<std::string> instruments, commands;
  /// Commands that are issued when the step begins, as text: "cut-flap saw_width=1.6".
  std::vector<std::string> on_entry;
  bool is_end = false;  ///< true: the operation is complete in this step
  std::vector<StepTransition> transitions;
  friend bool operator==(const ProcedureStep&, const ProcedureStep&) = default;
};

/// Limits and weight of a finding in the score of an operation.
struct ScoreLimit {
  std::string finding;  ///< name, such as "L4 left: breach"
  double full_at = 0,
         zero_at = 0;  ///< values with all points and with 0 points, in the finding's unit; must differ
  double weight = 1;   ///< points at `full_at`; 0: the finding is reported without points
  friend bool operator==(const ScoreLimit&, const ScoreLimit&) = default;
};

struct SurgicalProcedure {
  std::string name;   ///< "craniotomy"
  std::string title;  ///< in the user's words
  /// Names of instruments and commands that every step allows.
  std::vector<std::string> instruments, commands;
  std::vector<ProcedureStep> steps;  ///< the operation begins in the first one
  std::vector<ScoreLimit> score;     ///< for findings whose usual limits do not apply; see score_limits()

  bool is_empty() const noexcept { return steps.empty(); }
  /// Returns the index of a step; -1 if it is unknown.
  int find(const std::string& step) const noexcept;
  friend bool operator==(const SurgicalProcedure&, const SurgicalProcedure&) = default;
};

/// Largest number of steps of a procedure, and of transitions of a step.
inline constexpr std::size_t k_max_steps = 64;
/// Returns an error if a name or text is invalid, two steps have the same name, a transition or its
/// conditions are invalid, a step cannot be reached, no end can be reached from a step, or there are too many
/// steps or transitions. Does not check that commands, events and measurements exist. An empty procedure is
/// valid.
Status check(const SurgicalProcedure& procedure);

}  // namespace trephine::volume
