// All that an engine is at one moment, in values and immutable things: what a checkpoint keeps.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "sim/hand_trail.h"
#include "sim/module.h"
#include "sim/touch_fields.h"

namespace trephine::sim {

/// A place of the history.
struct HistoryPlace {
  World world;
  /// Offset fields of each scene with a round tool.
  std::vector<std::pair<std::shared_ptr<const haptics::TouchScene>, TouchFields::Kept>> fields;
};
struct HistoryEntry {
  std::uint64_t number = 0;            ///< another for each, from 1 on
  volume::VoxelBox box = k_no_voxels;  ///< what led here changed
  HistoryPlace here;
  /// Part of an operation that was opened in its middle: read when needed; null: `here` holds it.
  std::function<volume::Result<HistoryPlace>()> load = {};
  volume::Result<HistoryPlace> place() const { return load ? load() : here; }
};

/// A line of the history, by its name.
struct Branch {
  std::string name;
  /// Ends of strokes, oldest first; [0] is what can be gone back to.
  std::vector<std::shared_ptr<const HistoryEntry>> history;
  std::size_t position = 0;   ///< of those, where it stands
  std::size_t forgotten = 0;  ///< strokes before the first that stay for good
};

/// Data of a hand in addition to its scene.
struct HandWork {
  bool is_pressed = false, is_fresh = true;
  std::uint32_t noted_faults = 0;
  std::optional<ToolBall> body = std::nullopt;             ///< of its instrument, in the last tick
  std::optional<haptics::Placement> place = std::nullopt;  ///< where the hand was last
};

/// A job that began and has not ended: immutable things that any thread may read.
struct PendingJob {
  Id id;
  std::uint8_t hand = 0;
  std::shared_ptr<const Value> parameters;
  std::shared_ptr<const OperationState> input;
  std::function<std::shared_ptr<const JobResult>()> run;
  const JobType* type = nullptr;  ///< null: the engine's own
  std::size_t module = 0;
  std::uint64_t growths = 0, edits = 0;  ///< that there had been
  volume::VoxelBox cut = k_no_voxels;    ///< where anything had ever been cut
};

/// Scene of a hand without bodies, which are added.
struct HandTool {
  std::shared_ptr<const haptics::TouchScene> scene;
  std::shared_ptr<const haptics::ProxyMethod> method;
  std::uint64_t number = 0;  ///< of tools that the hand was given
  std::string own;           ///< the method with which the hand began
};

struct EngineImage {
  /// Frozen, and published by `serial`.
  OperationState now;
  std::uint64_t serial = 0;

  struct Hand {
    HandTool tool;
    std::shared_ptr<const haptics::WayOut> way;
    HandWork work;
    HandTrail trail;
  };
  std::vector<Hand> hands;
  std::vector<TouchFields> fields;

  Branch branch;
  std::vector<Branch> left_branches;  ///< others, in the order in which they were left first
  std::uint64_t last_entry = 0, growths = 0, edits = 0;
  bool is_stroke_changed = false;
  volume::VoxelBox stroke_box = k_no_voxels;
  volume::VoxelBox ever_cut = k_no_voxels;

  std::vector<PendingJob> jobs;
  std::uint32_t last_job = 0, last_body = 0;
};

}  // namespace trephine::sim
