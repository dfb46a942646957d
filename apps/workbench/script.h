// ScriptRun: plays a script: moves hands, sends commands, checks expectations and takes pictures.
#pragma once

#include "apps/workbench/performer.h"
#include "apps/workbench/script_watch.h"
#include "apps/workbench/sessions.h"
#include "data-tools/cases/script_file.h"
#include "sim/drivers/live_session.h"
#include "sim/drivers/lockstep.h"

namespace trephine::workbench {

/// Returns the path of a script's scan as the program opens it, or the name of a built-in phantom.
std::string scan_of(const data_tools::Script& script, const std::string& folder);
/// Returns the path of a script's procedure as the program opens it, or the name of a shipped procedure.
std::string procedure_of(const data_tools::Script& script, const std::string& folder);
/// Returns the paths of all files of a script as the program opens them.
std::vector<std::string> files_of(const data_tools::Script& script, const std::string& folder);

/// The simulated person who plays a script.
struct Performance {
  Skill skill;
  std::uint64_t seed = 1;
};

/// A script with its opened scan and prepared hands.
class ScriptRun {
 public:
  /// `folder`: base of the script's relative paths. Errors name the script's line. `performance`: the
  /// simulated person who moves the hands; empty: the hands follow the script exactly.
  static Result<std::unique_ptr<ScriptRun>> open(const data_tools::Script& script, const std::string& folder,
                                                 const std::string& where, const Listener& listener = {},
                                                 const std::optional<Performance>& performance = {});
  const Operation& operation() const { return operation_; }
  const std::vector<Place>& places() const noexcept { return places_; }
  /// Duration of the script, s.
  double duration() const noexcept { return duration_; }
  /// Plays the script once, without threads, and finishes the recorder. `recorder` may be null.
  Result<ScriptReport> play(sim::SessionWriter* recorder, PictureTaker take_picture = {},
                            const Listener& listener = {});
  /// Result of play_live().
  struct Live {
    haptics::ServoReport servo;
    int stalls = 0;  ///< number of times that fault_stale_scene was reset
    struct CommandResult {
      Status refused;      ///< reason why the command was refused, or its job had no effect; empty: done
      double done_at = 0;  ///< s, time at which the command and its job had ended
    };
    std::vector<CommandResult> results;  ///< of the issued commands, by time
  };
  /// Plays the script in real time on a servo thread, and finishes the recorder. Does not check expectations:
  /// watch() checks them in the recording.
  Result<Live> play_live(sim::SessionWriter& recorder, const Listener& listener = {});
  /// Checks the expectations and takes the pictures in a replay of the recording of play_live().
  Result<ScriptReport> watch(const Live& live, sim::Replay& recorded, PictureTaker take_picture = {},
                             const Listener& listener = {}) const;

 private:
  struct TimedCommand {
    const data_tools::ScriptCommand* from;
    sim::Command command;
  };
  ScriptRun(const data_tools::Script& script, Operation operation)
      : script_(script), operation_(std::move(operation)) {}
  Result<Place> find_trajectory_place(const data_tools::ScriptPlace& request) const;
  Status find_places(const std::string& where, const Performer* performer);
  bool has_places_on_bodies() const noexcept;
  Result<sim::Command> command_at(const TimedCommand& timed, const sim::OperationState& state) const;
  void perform(const Performer& performer);
  double planned_duration() const;
  std::vector<std::unique_ptr<haptics::Device>> devices() const;
  data_tools::Script script_;
  Operation operation_;
  std::vector<Place> places_;
  std::vector<haptics::PosePath> paths_;
  std::vector<TimedCommand> commands_;
  double duration_ = 0;
};

}  // namespace trephine::workbench
