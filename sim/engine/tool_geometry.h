// PreparedTool: a new tool of a hand (a point, a ball, a chain or a shell), prepared in the background.
#pragma once

#include "haptics/servo/servo_scene.h"
#include "sim/engine/engine_snapshot.h"
#include "sim/engine/touch_fields.h"

namespace trephine::sim {

/// Prepared scene of the hand, built from immutable data alone.
class PreparedTool final : public JobResult {
 public:
  std::shared_ptr<const haptics::TouchScene> scene;
  std::shared_ptr<const haptics::ProxyMethod> method;
  OffsetFields offsets;  ///< of the remaining matter when the job began; empty for a point or without cuts
  Status failed;         ///< reason why the tool is impossible
  std::uint64_t fingerprint = 0;  ///< of tool and fields
  std::uint64_t hash() const override { return fingerprint; }
};

/// Returns an error unless the radius is 0, or at least 0.02 times the smallest voxel spacing and at most 6
/// mm. The offset field of a smaller ball would be too large.
Status check_tool_radius(const volume::Volume& base, double radius);

/// Builds the scene, method and fields of `tool` with the requested geometry. `cut`: box that contains all
/// cuts of `version`.
std::shared_ptr<const PreparedTool> make_geometry(const HandTool& tool,
                                                  const Result<haptics::SharedTool>& request,
                                                  const volume::Version& version,
                                                  const volume::VoxelBox& cut);

}  // namespace trephine::sim
