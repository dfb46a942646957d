// Expectations and pictures of a script, checked tick by tick by any player.
#pragma once

#include <functional>
#include <span>

#include "apps/workbench/places.h"
#include "sim/engine.h"

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
  std::vector<ScriptCheck> checks;  ///< by line
  std::uint64_t ticks = 0;
  double seconds = 0;  ///< of the operation
  double strongest_force_n = 0;
  std::vector<double> strongest_of;                  ///< N, each hand
  std::vector<std::uint64_t> contact_ticks;          ///< each hand
  volume::Status recording;                          ///< how it ended, when it ended badly
  std::shared_ptr<const sim::OperationState> state;  ///< as it ended
  std::vector<sim::Measure> measures;
  std::vector<double> removed_mm3_by_label;
  bool is_met() const;
  /// Value in `measures`; not a number when there is no such name.
  double measure(std::string_view name) const;
};

/// After a tick of all hands.
struct ScriptMoment {
  double t = 0;
  std::span<const haptics::ServoRecord> hands;
  const sim::Engine& engine;
  volume::VoxelBox changed;  ///< since the picture before
};
/// `caption`: with its values.
using PictureTaker = std::function<volume::Status(const data_tools::ScriptPicture& picture,
                                                  const ScriptMoment& moment, const std::string& caption)>;

/// Borrows script and places.
class ScriptWatch {
 public:
  /// `take_picture`: set when pictures are requested.
  ScriptWatch(const data_tools::Script& script, const std::vector<Place>& places, double end,
              PictureTaker take_picture);
  /// Error when a picture could not be taken. `changed`: by this tick and the commands before it.
  volume::Status tick(double t, std::span<const haptics::ServoRecord> hands, const sim::Engine& engine,
                      const volume::VoxelBox& changed);
  /// A command was sent: as the script has it, or not.
  void record_command(const data_tools::ScriptCommand& command, double t, const volume::Status& refused);
  /// A command of `at` took until `done_at`: what is due from `at` on moves by as much.
  void wait_for(double at, double done_at) { waits_.push_back({at, done_at}); }
  /// Checks at the end.
  volume::Result<ScriptReport> finish(sim::Engine& engine);

 private:
  /// Measure of this name; empty without such a measure.
  std::optional<double> value_of(const std::string& what, int hand, const ScriptMoment& moment) const;
  /// A caption with values in place of {name} and {name:digits}.
  std::string caption_of(const data_tools::ScriptPicture& picture, const ScriptMoment& moment) const;
  void check(const data_tools::ScriptExpectation& request, const ScriptMoment& moment);
  volume::Status take_due(double t, const ScriptMoment& moment);

  const data_tools::Script* script_;
  const std::vector<Place>* places_;
  PictureTaker take_picture_;
  double end_;
  std::vector<const data_tools::ScriptExpectation*> requests_;  ///< in time
  std::vector<const data_tools::ScriptPicture*> pictures_;
  double due(const std::optional<double>& at) const;
  std::vector<std::pair<double, double>> waits_;
  std::size_t next_request_ = 0, next_picture_ = 0;
  std::vector<haptics::ServoRecord> hands_;  ///< of the last tick
  volume::VoxelBox changed_ = sim::k_no_voxels;
  ScriptReport report_;
};

/// Names that can be expected, in addition to the measures of modules.
std::vector<std::string> expectable();
/// Error when something is expected, or stands in a caption, that is not measured in such an operation.
volume::Status check_names(const data_tools::Script& script, const std::vector<Place>& places,
                           const sim::Engine& engine, const std::string& where);

}  // namespace trephine::workbench
