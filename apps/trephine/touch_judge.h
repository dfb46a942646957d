// Judges every tick of a touch by code that shares nothing with what it judges: the tool passed no surface,
// and rests where a frictionless one would.
#pragma once

#include <memory>
#include <vector>

#include "apps/trephine/drawn_judge.h"
#include "apps/workbench/touch_run.h"
#include "tests/checker/passage_judge.h"
#include "tests/scenes/promise.h"

namespace trephine::app {

class TouchJudge {
 public:
  /// Borrows the operation. Judges all shapes of its scan that hold from the front, and models.
  explicit TouchJudge(const workbench::Operation& operation);
  void observe(const workbench::TouchTick& tick);

  long fall_throughs() const { return falls_.fall_throughs() + passed_; }
  long stuck() const { return stuck_; }
  /// Judged ticks inside an object touched by depth images, deeper than these allow.
  long in_drawn() const { return drawn_.sunk + drawn_.let_through; }
  bool has_drawn() const { return has_drawn_; }
  /// Does the method promise anything?
  bool is_promised() const { return info_.solid != haptics::MethodInfo::Solid::nothing; }

 private:
  bool meets(const glm::dvec3& a, const glm::dvec3& b) const;
  glm::dvec3 judged(const glm::dvec3& p_volume) const;
  bool is_stuck(const workbench::TouchTick& tick, const glm::dvec3& hip) const;

  const haptics::TouchScene& scene_;
  const volume::Volume& base_;
  const haptics::MethodInfo& info_;
  bool is_smooth_;
  checker::SolidVoxels solid_;
  scenes::Promise promise_;                               ///< of the first shape
  std::vector<std::unique_ptr<scenes::Promise>> others_;  ///< of the others
  /// A round tool's middle is judged by the samples of its offset field, in that field's frame.
  std::shared_ptr<const volume::OffsetField> offset_;
  checker::SmoothSolid smooth_;
  std::vector<std::unique_ptr<checker::MeshWall>> models_;
  /// A model that a method knows by images of it, by its triangles in its own frame.
  struct ImagedModel {
    std::size_t item;
    checker::PassageJudge judge;
    glm::dvec3 last;  ///< the proxy in the tick before
    bool has_last = false;
  };
  void judge_passages(const workbench::TouchTick& tick);
  std::vector<ImagedModel> imaged_;
  long passed_ = 0;
  DrawnJudge drawn_;
  std::uint64_t look_every_ = DrawnJudge::k_every;  ///< ticks; of large models fewer
  int popped_ = -1;
  bool has_drawn_ = false;  ///< an object is touched by depth images, which move by themselves
  checker::FallThroughJudge falls_;
  long stuck_ = 0, resting_ = 0;
  glm::dvec3 last_hip_{1e300};
};

}  // namespace trephine::app
