// Player of a script: moves hands, sends commands, checks expectations, takes pictures.
#pragma once

#include "apps/workbench/script_watch.h"
#include "apps/workbench/sessions.h"
#include "data-tools/script_file.h"
#include "sim/live_session.h"
#include "sim/lockstep.h"

namespace trephine::workbench {

/// The scan that a script names, as the program sees it; a built-in one by its name.
std::string scan_of(const data_tools::Script& script, const std::string& folder);
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
  const std::vector<Place>& places() const noexcept { return places_; }
  /// s, of all of it.
  double duration() const noexcept { return duration_; }
  /// Plays all of it, once, without threads. `recorder`: may be null; it is finished.
  volume::Result<ScriptReport> play(sim::SessionWriter* recorder, PictureTaker take_picture = {},
                                    const Listener& listener = {});
  /// Plays it on a servo's thread, at its rate, and finishes the recorder. What the script expects is looked
  /// at afterwards, in the recording.
  struct Live {
    haptics::ServoReport servo;
    int stalls = 0;  ///< looks at which the servo had missed its watchdog
    struct Told {
      volume::Status refused;
      double done_at = 0;  ///< s, with the job that it began
    };
    std::vector<Told> told;  ///< the commands, in time
  };
  volume::Result<Live> play_live(sim::SessionWriter& recorder, const Listener& listener = {});
  volume::Result<ScriptReport> watch(const Live& live, sim::Replay& recorded, PictureTaker take_picture = {},
                                     const Listener& listener = {}) const;

 private:
  struct Told {
    const data_tools::ScriptCommand* from;
    sim::Command command;
  };
  ScriptRun(const data_tools::Script& script, Operation operation)
      : script_(script), operation_(std::move(operation)) {}
  volume::Status find_places(const std::string& where);
  std::vector<std::unique_ptr<haptics::Device>> devices() const;
  data_tools::Script script_;
  Operation operation_;
  std::vector<Place> places_;
  std::vector<haptics::PosePath> paths_;
  std::vector<Told> told_;
  double duration_ = 0;
};

}  // namespace trephine::workbench
