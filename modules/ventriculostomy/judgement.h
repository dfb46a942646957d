// Judgement of a catheter: the job that compares its path with the plan and with what it passed.
#pragma once

#include "modules/ventriculostomy/catheter.h"
#include "sim/api/module.h"

namespace trephine::ventriculostomy {

/// Job that judges a catheter. It changes no anatomy.
struct JudgeCatheter {
  std::string trajectory;  ///< of the plan, by name; empty: the nearest one for ventriculostomies
  std::vector<glm::dvec3> at =
      {};                 ///< mm, world: a point before the bone, and the tip; empty: the newest catheter
  std::int64_t item = 0;  ///< index of the bone's shape in the anatomy
  static const sim::Schema& schema();
};

/// Judgement of a catheter, the result of this module. Emitted at its tip.
struct CatheterJudged {
  bool is_any = false;          ///< a catheter was judged
  bool has_plan = false;        ///< it was compared with a trajectory of the plan
  std::string trajectory;       ///< name of that trajectory
  double entry_error = 0;       ///< mm, of the entry into the outer table
  double target_error = 0;      ///< mm, of the tip
  double direction_error = 0;   ///< degrees between the paths
  bool has_table = false;       ///< the path meets the outer table
  double depth_from_table = 0;  ///< mm, of the tip
  double angle_to_surface = 0;  ///< degrees between the path and the outer table; 90: perpendicular
  bool has_dura = false;        ///< the path meets the dura
  double depth_from_dura = 0;   ///< mm, of the tip
  std::string ventricle;        ///< label of the ventricle that contains the tip; empty: outside
  double in_ventricle = 0;      ///< mm of the path in ventricles
  std::string nearest;          ///< forbidden structure nearest to the path; empty: none in reach
  /// mm from the catheter's wall to that structure, at most 20; negative: depth of the wall in it
  double clearance = 0;
  glm::dvec3 entry{0.0}, tip{0.0};  ///< mm, world; the entry is on the outer table, or the outermost layer
  static const sim::Schema& schema();
};

/// Structure that a judged catheter passed. Emitted with the judgement, where the path first meets it.
struct CatheterCrossed {
  std::string structure;
  double length = 0;          ///< mm of the path in it
  bool is_forbidden = false;  ///< other than dura, brain and ventricles
  static const sim::Schema& schema();
};

/// Distance of a judged catheter to a forbidden structure other than dura, brain and ventricles. Emitted with
/// the judgement, at its tip.
struct CatheterClearance {
  std::string structure;
  double distance = 0;  ///< mm from the catheter's wall, at most 20; negative: depth
  double length = 0;    ///< mm of the catheter that are in it
  static const sim::Schema& schema();
};

/// The newest catheter of an operation: in a hand, left in place, or drawn out.
struct CatheterPath {
  glm::dvec3 start{0.0};                  ///< mm, world: where it met the outermost layer
  glm::dvec3 tip{0.0};                    ///< mm, world
  double diameter = Catheter().diameter;  ///< mm
};
std::optional<CatheterPath> newest_path(const sim::OperationState& operation);

/// Catheters that entered the head, oldest first. Undo does not change them: brain is not restored.
struct CatheterPassages {
  static constexpr std::size_t k_max = 256;  ///< kept; older ones are only counted
  std::int64_t count = 0;
  std::vector<glm::dvec3> starts, directions, tips;  ///< mm, world; unit; the deepest known positions
  std::vector<double> hands;
  static const sim::Schema& schema();
};

/// Structure that a judged path crosses.
struct Crossing {
  std::string structure;
  double length = 0;  ///< mm of the path in it
  bool is_forbidden = false;
  glm::dvec3 at_world{0.0};  ///< mm, first position in it
};
/// Position of the catheter relative to a forbidden structure.
struct Clearance {
  std::string structure;
  double distance = 0, length = 0;  ///< mm: as CatheterClearance
};
struct CatheterJudgement {
  CatheterJudged judged;
  std::vector<Crossing> crossings;    ///< in the order of the path
  std::vector<Clearance> clearances;  ///< of all forbidden structures
};
/// Judges a path. Requires that check_judging() accepts the request, and that the scan has labels.
CatheterJudgement judge(const JudgeCatheter& request, const sim::JobInput& input);

const sim::JobType& judge_job();
/// Returns an error if there is no catheter, if `at` is not two different points, or if the trajectory is
/// unknown.
Status check_judging(const JudgeCatheter& request, const sim::OperationState& operation);

}  // namespace trephine::ventriculostomy
