// EngineSnapshot: the state of an engine at one moment, as values and immutable data, for checkpoints.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "sim/api/module.h"
#include "sim/engine/hand_trail.h"
#include "sim/engine/touch_fields.h"

namespace trephine::sim {

/// State of the operation at an entry of the history.
struct EntryState {
  UndoableState undoable;
  /// Offset fields, one per scene with a round tool.
  std::vector<std::pair<std::shared_ptr<const haptics::TouchScene>, TouchFields::Kept>> fields;
};
struct HistoryEntry {
  std::uint64_t number = 0;            ///< unique, from 1 on
  volume::VoxelBox box = k_no_voxels;  ///< voxels changed since the previous entry
  EntryState stored;
  /// Reads the state on demand, if the operation was opened at a checkpoint. Null: the state is in `stored`.
  std::function<Result<EntryState>()> load = {};
  Result<EntryState> state() const { return load ? load() : stored; }
};

/// A named line of the history.
struct Branch {
  std::string name;
  /// Ends of strokes, oldest first; [0] is the oldest that undo can restore.
  std::vector<std::shared_ptr<const HistoryEntry>> history;
  std::size_t position = 0;       ///< index of the current entry
  std::size_t final_strokes = 0;  ///< number of strokes before [0], which can no longer be undone
};

/// Data of a hand in addition to its scene.
struct HandWork {
  bool is_pressed = false;  ///< its button is down, or its instrument is working
  bool is_fresh = true;     ///< InstrumentInput::is_fresh of the next tick
  std::uint32_t noted_faults = 0;
  std::optional<ToolBall> instrument_ball = std::nullopt;      ///< at the last tick
  std::optional<haptics::Placement> placement = std::nullopt;  ///< last known pose of the hand
};

/// A job that began and has not ended. Immutable data, for any thread.
struct PendingJob {
  Id id;
  std::uint8_t hand = 0;
  std::shared_ptr<const Value> parameters;
  std::shared_ptr<const OperationState> input;
  std::function<std::shared_ptr<const JobResult>()> run;
  const JobType* type = nullptr;  ///< null: a job of the engine
  std::size_t module = 0;
  /// Number of publications that added matter, at the start of the job.
  std::uint64_t addition_count = 0;
  volume::VoxelBox cut = k_no_voxels;  ///< box of all cuts before the job began
};

/// Scene and method of a hand, before the engine adds the detached bodies to the scene.
struct HandTool {
  std::shared_ptr<const haptics::TouchScene> scene;
  std::shared_ptr<const haptics::ProxyMethod> method;
  std::uint64_t change_count = 0;  ///< number of tool changes so far
  std::string initial_method;      ///< name of the method at the start
};

struct EngineSnapshot {
  OperationState state;      ///< frozen
  std::uint64_t serial = 0;  ///< of the newest published scene, which has the version of `state`

  struct Hand {
    HandTool tool;
    std::shared_ptr<const haptics::EscapePath> escape_path;  ///< newest escape path
    HandWork work;
    HandTrail trail;
  };
  std::vector<Hand> hands;
  std::vector<TouchFields> fields;

  Branch branch;
  std::vector<Branch> other_branches;  ///< SwitchBranch exchanges one of these with `branch`
  std::uint64_t last_entry = 0, addition_count = 0;
  bool is_stroke_changed = false;
  volume::VoxelBox stroke_box = k_no_voxels;
  volume::VoxelBox all_cuts_box = k_no_voxels;

  std::vector<PendingJob> jobs;
  std::uint32_t last_job = 0, last_body = 0;
};

}  // namespace trephine::sim
