// What a method promises not to enter (haptics/proxy/methods.h), built by the judges from a scene's samples.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "haptics/proxy/methods.h"
#include "tests/checker/mesh_judge.h"
#include "tests/checker/volume_samples.h"

namespace trephine::scenes {

/// The solid of one of a scene's shapes in one version, or, for a round tool, where its middle must not be.
/// The smooth solid and the cubes are read sample by sample with the judges' code; of triangles every one is
/// asked, in extended precision.
class Promise {
 public:
  /// `seen` null: untouched. Keeps what it needs of the scene but not the scene.
  Promise(const haptics::MethodInfo& method, const haptics::TouchScene& scene,
          std::shared_ptr<const haptics::TouchState> seen = nullptr, std::size_t shape = 0);

  /// Does the segment from a to b (volume frame), or the point where both are one, meet the solid?
  bool meets(const glm::dvec3& a, const glm::dvec3& b) const;

 private:
  std::shared_ptr<const volume::Volume> base_;
  std::shared_ptr<const volume::OffsetField> offset_;  ///< null for a point
  std::optional<volume::Frame> lattice_;               ///< of depth images
  std::unique_ptr<checker::SmoothSolid> smooth_;
  std::unique_ptr<checker::FallThroughJudge> cubes_;
  std::unique_ptr<checker::MeshWall> triangles_;
};

/// The offset field in which a shape is touched; null for a point.
std::shared_ptr<const volume::OffsetField> touched_offset(const haptics::TouchScene& scene,
                                                          const haptics::TouchState* seen,
                                                          std::size_t shape = 0);
/// The smooth solid of a shape, in the frame of touched_offset() where there is one.
checker::SmoothSolid touched_smooth_solid(const haptics::TouchScene& scene,
                                          std::shared_ptr<const haptics::TouchState> seen,
                                          std::size_t shape = 0);

}  // namespace trephine::scenes
