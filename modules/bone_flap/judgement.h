// Judgement of a bone flap: the job that compares the last flap with its target, its plan and the forbidden
// structures.
#pragma once

#include "modules/bone_flap/bone_flap.h"

namespace trephine::bone_flap {

/// Job that judges the last flap. It changes no anatomy.
struct JudgeFlap {
  std::string target;                    ///< label to expose; empty: that of the first target of the plan
  std::string outline;                   ///< name of an outline of the plan; empty: `planned`
  std::vector<glm::dvec3> planned = {};  ///< mm, world; empty: the nearest outline of the plan
  static const sim::Schema& schema();
};

/// Judgement of a flap. Emitted at its centre.
struct FlapJudged {
  std::int64_t flap = 0;  ///< number of the flap, from 1 on; 0: it was cut by hand
  double area = 0;        ///< of its outer surface, mm2
  double perimeter = 0, length = 0, width = 0,
         roundness = 0;  ///< mm, roundness without unit; see OutlineShape
  std::string target;
  bool has_target = false;                    ///< false: no target, or its label has no voxels
  double exposed = 0, margin = 0, depth = 0;  ///< %, mm, mm; see LabelExposure
  bool has_plan = false;                      ///< the outline was compared with a plan
  double plan_mean = 0, plan_worst = 0;       ///< mm; see OutlineDistance
  static const sim::Schema& schema();
};

/// Clearance between the saw and a forbidden structure. Emitted with a judgement, at the nearest position.
struct FlapClearance {
  std::string structure;
  double distance = 0;       ///< mm, at most Forbidden::k_reach; negative: depth of the cut into it
  bool is_stripped = false;  ///< the saw's foot strips it off the bone
  static const sim::Schema& schema();
};

/// Returns the outline of the plan with this name; null if there is no such outline.
const volume::PlannedOutline* find_outline(const sim::OperationState& operation, const std::string& name);
/// Returns an error if the plan has no outline with this name; the error lists the outlines of the plan. An
/// empty name is valid.
Status check_outline(const char* where, const std::string& name, const sim::OperationState& operation);

const sim::JobType& judge_job();
/// Returns an error if there is no flap to judge, or if the planned outline is invalid.
Status check_judging(const JudgeFlap& request, const sim::OperationState& operation);
/// Returns the newest judgement of the current flap; null if it was not judged.
const FlapJudged* judgement_of(const sim::OperationState& operation);

}  // namespace trephine::bone_flap
