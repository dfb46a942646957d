// ScriptWatch: checks expectations and takes pictures of a script, tick by tick, for any player.
#pragma once

#include <functional>
#include <span>

#include "apps/workbench/places.h"
#include "sim/engine/engine.h"

namespace trephine::workbench {

/// An expectation or command of a script, and whether it was met.
struct ScriptCheck {
  int line = 0;      ///< of the script
  std::string what;  ///< "100 <= removed_mm3", or a command
  double at = 0;     ///< s
  bool is_met = false;
  std::string found;  ///< found value, or reason of a refusal, as text
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
  volume::VoxelBox changed;  ///< since the previous picture
};
/// Takes a picture. `caption`: with inserted values.
using PictureTaker = std::function<Status(const data_tools::ScriptPicture& picture,
                                          const ScriptMoment& moment, const std::string& caption)>;

/// Checks one run of a script. Borrows the script and the places.
class ScriptWatch {
 public:
  /// `end`: duration of the script, s. Empty `take_picture`: takes no pictures.
  ScriptWatch(const data_tools::Script& script, const std::vector<Place>& places, double end,
              PictureTaker take_picture);
  /// Call after each tick. `changed`: by this tick and the commands before it. Error if a picture fails.
  Status tick(double t, std::span<const haptics::ServoRecord> hands, const sim::Engine& engine,
              const volume::VoxelBox& changed);
  /// Records the outcome of a command: refused or not, as the script expects.
  void record_command(const data_tools::ScriptCommand& command, double t, const Status& refused);
  /// Delays all checks and pictures from `at` (s) on, since a command of that time was done only at
  /// `done_at`.
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

/// Returns the names of measurements, in addition to the measures of modules.
std::vector<std::string> quantity_names();
/// Checks that all names in expectations and captions are measured in such an operation.
Status check_names(const data_tools::Script& script, const std::vector<Place>& places,
                   const sim::Engine& engine, const std::string& where);

}  // namespace trephine::workbench
