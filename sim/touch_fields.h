// Offset fields of round tools, derived of what is left and updated a while later: which are outdated.
#pragma once

#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "haptics/scene/touch_state.h"
#include "sim/work.h"

namespace trephine::sim {

/// Offset fields of a round tool to be made again: those of `version` in `box`. Made on any thread, from
/// immutable things alone.
struct OffsetJob {
  std::uint64_t serial = 0;  ///< of the ServoScene in which the version was published
  std::size_t hand = 0;      ///< the first that feels with them
  std::shared_ptr<const haptics::TouchScene> scene;
  std::shared_ptr<const volume::Version> version;
  volume::VoxelBox box = k_no_voxels;
  using Offsets = haptics::TouchState::OffsetFields;
  Offsets before;  ///< one a shape of the base
  /// Milliseconds to tens of them, by the size of the box and of the tool; the same bits whatever `threads`.
  Offsets make(int threads = 1) const;
};

/// State of one scene, by the cuts since its fields were made. A value.
class TouchFields {
 public:
  explicit TouchFields(std::shared_ptr<const haptics::TouchScene> scene) : scene_(std::move(scene)) {}

  /// For the next published state; empty where nothing was cut yet.
  const OffsetJob::Offsets& newest() const noexcept { return newest_; }
  bool is_stale() const noexcept { return !cuts_.empty(); }
  /// Tick of the first cut that they do not know; they are stale.
  std::uint64_t oldest_serial() const noexcept { return cuts_.front().serial; }
  /// Something was cut in `box`, and published.
  void record_cut(std::shared_ptr<const volume::Version> version, std::uint64_t serial,
                  const volume::VoxelBox& box);
  /// For all that was cut so far; nothing when the fields are up to date.
  std::optional<OffsetJob> job() const;
  /// For what was published then; nothing when that did not lead here.
  std::optional<OffsetJob> job_of(std::uint64_t serial) const;
  /// Takes what that job made. False, and nothing is changed, when it is of no state that led here, after an
  /// undo say.
  bool take(std::uint64_t serial, OffsetJob::Offsets made);

  /// History entry in addition to a version.
  struct Kept {
    OffsetJob::Offsets fields;
    volume::VoxelBox owed = k_no_voxels;  ///< where they are older than the version
  };
  Kept keep() const;
  /// `version`: to which the history goes, published again by this serial.
  void go_back(const Kept& kept, std::shared_ptr<const volume::Version> version, std::uint64_t serial);
  const std::shared_ptr<const haptics::TouchScene>& scene() const noexcept { return scene_; }

  // ---- saving ----
  const volume::VoxelBox& owed() const noexcept { return owed_; }
  /// The cuts that are not in them: when they were published, and where.
  std::vector<std::pair<std::uint64_t, volume::VoxelBox>> cuts() const;
  /// The last of the cuts was published as `version`; of the others jobs come from elsewhere.
  static TouchFields of(std::shared_ptr<const haptics::TouchScene> scene, Kept kept,
                        std::span<const std::pair<std::uint64_t, volume::VoxelBox>> cuts,
                        std::shared_ptr<const volume::Version> version);

 private:
  struct Cut {
    std::shared_ptr<const volume::Version> version;
    std::uint64_t serial;
    volume::VoxelBox box;
  };
  std::shared_ptr<const haptics::TouchScene> scene_;
  OffsetJob::Offsets newest_;
  volume::VoxelBox owed_ = k_no_voxels;  ///< what was cut before the oldest of `cuts_`, and is not in them
  std::vector<Cut> cuts_;                ///< since, oldest first
};

}  // namespace trephine::sim
