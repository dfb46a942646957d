// ToolAudit: judges how deep matter enters a tool with six degrees of freedom.
#pragma once

#include <memory>
#include <vector>

#include "apps/cli/audit/touchable_solids.h"
#include "apps/verify/smooth_judge.h"
#include "apps/verify/tool_judge.h"
#include "haptics/servo/servo_record.h"

namespace trephine::cli {

/// Judges the pose of a whole tool or of a rigid set of balls: many positions of its surface, which are
/// independent of the points of the tool, are tested for matter: the anatomy by the scan's own samples and
/// cuts, models by their triangles.
class ToolAudit {
 public:
  static constexpr std::uint64_t k_every = 16;  ///< ticks between judged poses

  /// Requires a tool with six degrees of freedom. Without has_positions(), it cannot be judged.
  explicit ToolAudit(const haptics::TouchScene& scene);
  /// False for a tool that was sampled from a mesh, whose surface the session does not contain.
  bool has_positions() const noexcept { return judge_.position_count() > 0; }
  void set_version(const std::shared_ptr<const volume::Version>& version);
  /// Judges the tool of a tick. `popped`: the shape that the tool passes through; -1 if no shape. `planted`:
  /// motion that is added to the tool's pose as a fault, mm.
  void judge(const haptics::ServoRecord& record, const TouchableSolids& solids, int popped,
             const glm::dvec3& planted);
  long judged() const noexcept { return judged_; }
  long too_deep() const noexcept { return too_deep_; }
  double deepest_mm() const noexcept { return deepest_; }
  double allowed_mm() const noexcept { return allowed_; }

 private:
  const haptics::TouchScene& scene_;
  verify::ToolJudge judge_;
  double allowed_;
  std::vector<verify::SmoothSolid> solids_;
  long judged_ = 0, too_deep_ = 0;
  double deepest_ = 0;
};

}  // namespace trephine::cli
