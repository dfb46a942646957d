// OpenedStructures: structures of a scan that are visible through openings in its bone, and through the
// natural gaps of a spine: dura, brain, dural sac, vessels.
#pragma once

#include <future>
#include <memory>
#include <set>
#include <tuple>
#include <vector>

#include "apps/view/chunk_meshes.h"

namespace trephine::view {

/// Meshes the labelled structures near removed matter for a BoneLayer, as one solid that is coloured by the
/// label just below its surface. A cut up to 3 voxels deep is not drawn if more of the structure remains
/// beneath it: the structure counts as a membrane that was pushed off the bone. The dural sac, nerves and
/// discs of a spine are meshed whole. Scans without such labels, and heads without openings, have no cost.
/// Borrows the scene. Drawing thread only.
class OpenedStructures {
 public:
  /// `labels`: label values of the structures to draw, some or all of untouchable_structures().
  OpenedStructures(const haptics::TouchScene& scene, std::vector<int> labels);
  ~OpenedStructures();
  OpenedStructures(const OpenedStructures&) = delete;
  OpenedStructures& operator=(const OpenedStructures&) = delete;

  /// Requests the structures near all removed matter of a version. The first call also requests the
  /// structures in natural gaps.
  void request_all(const std::shared_ptr<const volume::Version>& version);
  /// Requests the structures near the voxels that changed since the previous version.
  void request(const std::shared_ptr<const volume::Version>& version, const volume::VoxelBox& changed);
  /// Returns the chunks finished since the last call. Their shape number is the number of base_shapes().
  std::vector<ChunkMesh> take();
  /// Waits until all requests are finished.
  void finish();
  /// True if all requests are finished and take() has returned their chunks.
  bool is_complete() const;

 private:
  struct Solid;
  void start();
  void collect();

  const haptics::TouchScene* scene_;
  std::vector<int> labels_;
  std::unique_ptr<Solid> solid_;  ///< while the job runs, used only by the job
  std::future<std::vector<ChunkMesh>> job_;
  std::vector<ChunkMesh> done_;
  std::shared_ptr<const volume::Version> version_;           ///< newest requested version
  volume::VoxelBox waiting_{glm::ivec3(0), glm::ivec3(-1)};  ///< changed voxels; empty: no request
  bool are_gaps_waiting_ = false;  ///< the structures in natural gaps were not requested yet
};

}  // namespace trephine::view
