// Another tool in a hand: a ball of another radius, or a point, prepared in the background.
#pragma once

#include "haptics/servo/servo_scene.h"
#include "sim/engine_image.h"
#include "sim/touch_fields.h"

namespace trephine::sim {

/// Prepared scene of the hand, made of immutable things alone.
class MadeGeometry final : public JobResult {
 public:
  std::shared_ptr<const haptics::TouchScene> scene;
  std::shared_ptr<const haptics::ProxyMethod> method;
  OffsetJob::Offsets offsets;     ///< of what was left when the job began; empty for a point
  volume::Status failed;          ///< why there is no such tool
  std::uint64_t fingerprint = 0;  ///< of fields and radius
  std::uint64_t hash() const override { return fingerprint; }
};

/// 0, or not much smaller than the voxels, whose fields would be without measure: error.
volume::Status check_tool_radius(const volume::Volume& base, double radius);

/// `tool` as it is, with such a geometry. `cut`: where anything was ever cut of `version`.
std::shared_ptr<const MadeGeometry> make_geometry(const HandTool& tool, const ToolGeometry& request,
                                                  const volume::Version& version,
                                                  const volume::VoxelBox& cut);

}  // namespace trephine::sim
