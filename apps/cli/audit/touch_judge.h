// TouchJudge: judges every tick of a touch with independent code: the tool passed through no surface, and
// rests where a frictionless tool would rest, up to the distance that friction can hold.
#pragma once

#include <memory>
#include <vector>

#include "apps/bench/scenes/guaranteed_solid.h"
#include "apps/cli/audit/depth_image_judge.h"
#include "apps/verify/passage_judge.h"
#include "apps/workbench/touch_run.h"

namespace trephine::cli {

class TouchJudge {
 public:
  /// Borrows the operation. Judges the first shape of its scan, those other shapes whose front alone blocks,
  /// and models.
  explicit TouchJudge(const workbench::Operation& operation);
  void observe(const workbench::TouchTick& tick);

  /// False for a tool with six degrees of freedom, which `trephine audit` judges.
  bool judges_falls() const { return !scene_.tool->is_six_dof(); }
  long fall_throughs() const { return falls_.fall_throughs() + passed_; }
  long stuck() const { return stuck_; }
  /// Number of judged ticks in which the proxy was in an object touched by depth images, deeper than the
  /// tolerance of the images.
  long ticks_inside_depth_object() const { return depth_judge_.too_deep + depth_judge_.passable; }
  bool has_depth_objects() const { return has_depth_objects_; }
  /// True if the method guarantees not to enter a solid.
  bool is_guaranteed() const { return info_.solid != haptics::MethodInfo::Solid::nothing; }

 private:
  bool meets(const glm::dvec3& a, const glm::dvec3& b) const;
  /// Returns a position of the volume frame in the frame of `smooth_`.
  glm::dvec3 to_smooth_frame(const glm::dvec3& p_volume) const;
  bool is_stuck(const workbench::TouchTick& tick, const glm::dvec3& hip) const;

  const haptics::TouchScene& scene_;
  const volume::Volume& base_;
  const haptics::MethodInfo& info_;
  bool is_smooth_;
  verify::SolidVoxels solid_;
  scenes::GuaranteedSolid guaranteed_;                            ///< of the first shape
  std::vector<std::unique_ptr<scenes::GuaranteedSolid>> others_;  ///< of the other shapes
  /// Offset field of a round tool; its samples judge the tool's centre, in the frame of the field.
  std::shared_ptr<const volume::OffsetField> offset_;
  verify::SmoothSolid smooth_;
  std::vector<std::unique_ptr<verify::MeshWall>> models_;
  /// A model that a method touches by images; judged by its triangles in its own frame.
  struct ImagedModel {
    std::size_t item;
    verify::PassageJudge judge;
    glm::dvec3 last;  ///< the proxy in the previous tick
    bool has_last = false;
  };
  void judge_passages(const workbench::TouchTick& tick);
  std::vector<ImagedModel> imaged_;
  long passed_ = 0;
  DepthImageJudge depth_judge_;
  std::uint64_t depth_interval_ =
      DepthImageJudge::k_every;  ///< ticks between judgements; longer for large models
  int popped_ = -1;
  bool has_depth_objects_ = false;  ///< an object is touched by depth images; it may move by itself
  verify::FallThroughJudge falls_;
  long stuck_ = 0, resting_ = 0;
  glm::dvec3 last_hip_{1e300};
};

}  // namespace trephine::cli
