// TouchFields: offset fields of round tools, updated some time after each cut, and the cuts that they do not
// include yet.
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

  /// Returns the fields for the next published state; empty before the first cut.
  const OffsetFields& newest() const noexcept { return newest_; }
  bool is_stale() const noexcept { return !cuts_.empty(); }
  /// Serial of the first cut that the fields do not include; requires is_stale().
  std::uint64_t oldest_serial() const noexcept { return cuts_.front().serial; }
  /// Records a cut in `box`, published as `version` by `serial`.
  void record_cut(std::shared_ptr<const volume::Version> version, std::uint64_t serial,
                  const volume::VoxelBox& box);
  /// Returns the job for all cuts so far; empty if the fields are up to date. `hand`: one that uses them.
  std::optional<DerivedJob> job(std::uint8_t hand) const;
  /// Returns the job for the cuts up to a serial; empty if the cuts have no such serial, for example after an
  /// undo.
  std::optional<DerivedJob> job_of(std::uint64_t serial, std::uint8_t hand) const;
  /// Adopts the result of that job. Returns false, without changes, if the cuts have no such serial, for
  /// example after an undo.
  bool adopt(std::uint64_t serial, OffsetFields result);

  /// Fields of a history entry, in addition to its version.
  struct Kept {
    OffsetFields fields;
    volume::VoxelBox stale_box = k_no_voxels;  ///< voxels where they are older than the version
  };
  Kept keep() const;
  /// Restores kept fields. `version`: the restored version, published again by `serial`.
  void go_back(const Kept& kept, std::shared_ptr<const volume::Version> version, std::uint64_t serial);
  const std::shared_ptr<const haptics::TouchScene>& scene() const noexcept { return scene_; }

  // ---- saving ----
  const volume::VoxelBox& stale_box() const noexcept { return stale_box_; }
  /// Returns the cuts that the fields do not include, with their serials.
  std::vector<std::pair<std::uint64_t, volume::VoxelBox>> cuts() const;
  /// Restores saved fields. The last cut was published as `version`. The other cuts have no job: results for
  /// them must be submitted.
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
