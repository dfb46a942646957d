// GuaranteedSolid: the region that a method guarantees not to enter (haptics/methods/methods.h), built by the
// judges from a scene's samples.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "apps/verify/mesh_judge.h"
#include "apps/verify/volume_samples.h"
#include "haptics/methods/methods.h"

namespace trephine::scenes {

/// The solid of one shape of a scene in one version. For a round tool it is the region that the tool's centre
/// must not enter. The smooth solid and the cubes are read sample by sample with the judges' code; every
/// triangle near a segment is tested in extended precision.
class GuaranteedSolid {
 public:
  /// `touch_state` null: the uncut volume. Copies the needed parts of the scene, and keeps no reference
  /// to it.
  GuaranteedSolid(const haptics::MethodInfo& method, const haptics::TouchScene& scene,
                  std::shared_ptr<const haptics::TouchState> touch_state = nullptr, std::size_t shape = 0);

  /// True if the segment from a to b (volume frame), or the point if both are equal, meets the solid.
  bool meets(const glm::dvec3& a, const glm::dvec3& b) const;

 private:
  std::shared_ptr<const volume::Volume> base_;
  std::shared_ptr<const volume::OffsetField> offset_;  ///< null for a point
  std::optional<volume::Frame> lattice_;               ///< of depth images
  std::unique_ptr<verify::SmoothSolid> smooth_;
  std::unique_ptr<verify::FallThroughJudge> cubes_;
  std::unique_ptr<verify::MeshWall> triangles_;
};

/// Returns the offset field of a shape for the tool; null if the tool is a point.
std::shared_ptr<const volume::OffsetField> touch_offset_field(const haptics::TouchScene& scene,
                                                              const haptics::TouchState* touch_state,
                                                              std::size_t shape = 0);
/// Returns the smooth solid of a shape, in the frame of touch_offset_field(); for a point, in the frame of
/// the volume.
verify::SmoothSolid touched_smooth_solid(const haptics::TouchScene& scene,
                                         std::shared_ptr<const haptics::TouchState> touch_state,
                                         std::size_t shape = 0);

}  // namespace trephine::scenes
