// Structures of a scan that are seen through openings in its bone: dura, brain, cord, vessels.
#pragma once

#include <future>
#include <memory>
#include <set>
#include <tuple>
#include <vector>

#include "apps/view/chunk_meshes.h"

namespace trephine::view {

/// Meshes the labelled structures near what was removed, for a BoneLayer: one solid, coloured by what lies
/// just below its surface. What a tool takes off it to a depth of 3 voxels is drawn whole, as a membrane that
/// was pushed off the bone, where more of the structure is left beneath. A scan without such labels, and one without openings, cost nothing. Borrows the
/// scene; one thread, that which draws.
class OpenedStructures {
 public:
  explicit OpenedStructures(const haptics::TouchScene& scene);
  ~OpenedStructures();
  OpenedStructures(const OpenedStructures&) = delete;
  OpenedStructures& operator=(const OpenedStructures&) = delete;

  /// Requests the structures near all that a version lacks.
  void request_all(const std::shared_ptr<const volume::Version>& version);
  /// Requests those near the voxels that differ from the version before.
  void request(const std::shared_ptr<const volume::Version>& version, const volume::VoxelBox& changed);
  /// Returns the chunks that were finished since the last call. Their shapes are numbered after the scene's.
  std::vector<ChunkMesh> take();
  /// Waits until nothing is left to do.
  void finish();
  bool is_complete() const;

  /// Returns the label values of a scan that name such structures.
  static std::vector<int> structures_of(const haptics::TouchScene& scene);

 private:
  struct Solid;
  void start();
  void collect();

  const haptics::TouchScene* scene_;
  std::vector<int> labels_;
  std::unique_ptr<Solid> solid_;  ///< of the job alone, while one runs
  std::future<std::vector<ChunkMesh>> job_;
  std::vector<ChunkMesh> done_;
  std::shared_ptr<const volume::Version> version_;  ///< the newest that was asked for
  volume::VoxelBox waiting_{glm::ivec3(0), glm::ivec3(-1)};
};

}  // namespace trephine::view
