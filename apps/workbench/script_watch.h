// ScriptWatch: checks the expectations and takes the pictures of a script, tick by tick, for a script that is
// played or replayed.
#pragma once

#include <functional>
#include <span>

#include "apps/workbench/places.h"
#include "sim/engine/engine.h"

namespace trephine::workbench {

/// Result of an expectation, a command or a picture of a script.
struct ScriptCheck {
  int line = 0;      ///< of the script
  std::string what;  ///< "100 <= removed_mm3", "cut-flap is done" or "a.png is taken"
  double at = 0;     ///< s
  bool is_met = false;
  std::string found;  ///< measured value, or reason of a refusal or failure, as text
};

struct ScriptReport {
  std::vector<ScriptCheck> checks;  ///< by line
  std::uint64_t ticks = 0;
  double seconds = 0;  ///< of the operation
  double strongest_force_n = 0;
  std::vector<double> strongest_of;                  ///< N, strongest force of each hand
  std::vector<std::uint64_t> contact_ticks;          ///< per hand
  Status recording_error;                            ///< failure of the recording, if any
  std::shared_ptr<const sim::OperationState> state;  ///< at the end
  std::vector<sim::Measure> measures;
  std::vector<double> removed_mm3_by_label;
  bool is_met() const;
  /// Returns a value of `measures`; not a number if the name is unknown.
  double measure(std::string_view name) const;
};

/// State after a tick of all hands.
struct ScriptMoment {
  double t = 0;  ///< s
  std::span<const haptics::ServoRecord> hands;
  const sim::Engine& engine;
  volume::VoxelBox changed;  ///< voxels that may look different since the previous picture
};
/// Takes a picture. `caption`: caption of the picture with its values inserted. An error of kind `refused` is
/// recorded as an unmet check; other errors end the run.
using PictureTaker = std::function<Status(const data_tools::ScriptPicture& picture,
                                          const ScriptMoment& moment, const std::string& caption)>;

/// Checks one run of a script. Borrows the script and the places.
class ScriptWatch {
 public:
  /// `end`: duration of the script, s. If `take_picture` is empty, no pictures are taken.
  ScriptWatch(const data_tools::Script& script, const std::vector<Place>& places, double end,
              PictureTaker take_picture);
  /// Must be called after each tick. `changed`: voxels that this tick and the commands before it changed.
  /// Error if a picture fails.
  Status tick(double t, std::span<const haptics::ServoRecord> hands, const sim::Engine& engine,
              const volume::VoxelBox& changed);
  /// Records a check if a command was refused, or if the script expects its refusal. `refused`: reason of the
  /// refusal; empty: the command was carried out.
  void record_command(const data_tools::ScriptCommand& command, double t, const Status& refused);
  /// Delays all checks and pictures whose time is `at` (s) or later, by the duration until `done_at`: the
  /// time at which a command with the time `at` had ended. Those without a time are not delayed.
  void wait_for(double at, double done_at) { waits_.push_back({at, done_at}); }
  /// Makes the checks and pictures that are due at the end, and returns the report.
  Result<ScriptReport> finish(sim::Engine& engine);

 private:
  /// Returns the measurement of this name; empty if it is unknown.
  std::optional<double> value_of(const std::string& measurement, int hand, const ScriptMoment& moment,
                                 bool accepts_stale) const;
  /// Returns the caption, with {name} and {name:digits} replaced by values.
  std::string caption_of(const data_tools::ScriptPicture& picture, const ScriptMoment& moment) const;
  void check(const data_tools::ScriptExpectation& request, const ScriptMoment& moment);
  Status take_due(double t, const ScriptMoment& moment);

  const data_tools::Script* script_;
  const std::vector<Place>* places_;
  PictureTaker take_picture_;
  double end_;
  std::vector<const data_tools::ScriptExpectation*> requests_;  ///< by time
  std::vector<const data_tools::ScriptPicture*> pictures_;
  double due(const std::optional<double>& at) const;
  std::vector<std::pair<double, double>> waits_;
  std::size_t next_request_ = 0, next_picture_ = 0;
  std::vector<haptics::ServoRecord> hands_;  ///< of the last tick
  volume::VoxelBox changed_ = sim::k_no_voxels;
  ScriptReport report_;
};

/// Returns the names of all measurements except the measures of modules.
std::vector<std::string> quantity_names();
/// Checks that an operation with this engine can measure all names in expectations and captions. `where`:
/// name of the script in errors.
Status check_names(const data_tools::Script& script, const std::vector<Place>& places,
                   const sim::Engine& engine, const std::string& where);

}  // namespace trephine::workbench
