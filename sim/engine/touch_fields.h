// TouchFields: offset fields of round tools, which are updated some time after each cut, and the cuts that
// the fields do not include yet.
#pragma once

#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "sim/api/work.h"
#include "sim/engine/derived_job.h"

namespace trephine::sim {

/// Offset fields of one scene, and the cuts since they were built. A value.
class TouchFields {
 public:
  explicit TouchFields(std::shared_ptr<const haptics::TouchScene> scene) : scene_(std::move(scene)) {}

  /// Returns the fields for the next published state. Empty before the first adoption: the fields of the
  /// scene apply.
  const OffsetFields& newest() const noexcept { return newest_; }
  bool is_stale() const noexcept { return !cuts_.empty(); }
  /// Serial of the first cut that the fields do not include; requires is_stale().
  std::uint64_t oldest_serial() const noexcept { return cuts_.front().serial; }
  /// Records a cut in `box`. `version`: the anatomy after the cut; `serial`: of the scene that published it.
  void record_cut(std::shared_ptr<const volume::Version> version, std::uint64_t serial,
                  const volume::VoxelBox& box);
  /// Returns the job for all cuts so far; empty if the fields are up to date. `hand`: any hand that uses the
  /// fields.
  std::optional<DerivedJob> job(std::uint8_t hand) const;
  /// Returns the job for the recorded cuts up to a serial. Empty if no recorded cut has this serial, for
  /// example after an undo, or if the cut has no job (see of()).
  std::optional<DerivedJob> job_of(std::uint64_t serial, std::uint8_t hand) const;
  /// Adopts the result of that job. Returns false, without changes, if no recorded cut has this serial, for
  /// example after an undo.
  bool adopt(std::uint64_t serial, OffsetFields result);

  /// Fields of a history entry, in addition to its version.
  struct Kept {
    OffsetFields fields;
    volume::VoxelBox stale_box = k_no_voxels;  ///< voxels where the fields are older than the version
  };
  Kept keep() const;
  /// Restores kept fields. `version`: the restored version; `serial`: of the scene that publishes it again.
  void go_back(const Kept& kept, std::shared_ptr<const volume::Version> version, std::uint64_t serial);
  const std::shared_ptr<const haptics::TouchScene>& scene() const noexcept { return scene_; }

  // ---- saving ----
  const volume::VoxelBox& stale_box() const noexcept { return stale_box_; }
  /// Returns the cuts that the fields do not include, with their serials.
  std::vector<std::pair<std::uint64_t, volume::VoxelBox>> cuts() const;
  /// Restores saved fields. `version`: the anatomy after the last cut. The other cuts have no job, since
  /// their versions are not saved: results for them must be submitted.
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
  OffsetFields newest_;
  /// Voxels of cuts that are older than `cuts_` and not included in the fields.
  volume::VoxelBox stale_box_ = k_no_voxels;
  std::vector<Cut> cuts_;  ///< later cuts that the fields do not include, oldest first
};

}  // namespace trephine::sim
