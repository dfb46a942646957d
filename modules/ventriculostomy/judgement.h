// Judgement of a catheter: the job that compares the path of a catheter with the plan, and measures the
// structures along the path.
#pragma once

#include "modules/ventriculostomy/catheter.h"
#include "sim/api/module.h"

namespace trephine::ventriculostomy {

/// Job that judges a catheter. It changes no anatomy.
struct JudgeCatheter {
  /// Name of a trajectory of the plan; empty: the trajectory of the group ventriculostomy with the nearest
  /// entry.
  std::string trajectory;
  std::vector<glm::dvec3> at =
      {};                 ///< mm, world: a point before the bone, and the tip; empty: the newest catheter
  std::int64_t item = 0;  ///< index of the bone's shape in the anatomy
  static const sim::Schema& schema();
};

/// Judgement of a catheter, the result of this module. Emitted at its tip.
struct CatheterJudged {
  bool has_value = false;       ///< a catheter was judged
  bool has_plan = false;        ///< the path was compared with a trajectory of the plan
  std::string trajectory;       ///< name of that trajectory
  double entry_error = 0;       ///< mm from the planned entry to `entry`
  double target_error = 0;      ///< mm from the planned target to the tip
  double direction_error = 0;   ///< degrees between the path and the trajectory
  bool has_table = false;       ///< the path meets the outer table
  double depth_from_table = 0;  ///< mm from the outer table to the tip, along the path
  double angle_to_surface = 0;  ///< degrees between the path and the outer table; 90: perpendicular
  bool has_dura = false;        ///< the path meets the dura
  double depth_from_dura = 0;   ///< mm from the dura to the tip, along the path
  std::string ventricle;        ///< label of the ventricle that contains the tip; empty: no ventricle
  double in_ventricle = 0;      ///< mm of the path in ventricles
  /// Forbidden structure nearest to the path, other than dura, brain and ventricles; empty: no such structure
  /// within 20 mm.
  std::string nearest;
  /// mm from the catheter's wall to that structure, at most 20; negative: depth of the wall in it
  double clearance = 0;
  /// mm, world. The entry is on the outer table or, if the path meets no bone, at the start of the path.
  glm::dvec3 entry{0.0}, tip{0.0};
  static const sim::Schema& schema();
};

/// Structure that a judged catheter passed. Emitted with the judgement, where the path first meets it.
struct CatheterCrossed {
  std::string structure;
  double length = 0;          ///< mm of the path in it
  bool is_forbidden = false;  ///< a forbidden structure other than dura, brain and ventricles
  static const sim::Schema& schema();
};

/// Distance of a judged catheter to a forbidden structure other than dura, brain and ventricles. Emitted with
/// the judgement, at the tip of the catheter.
struct CatheterClearance {
  std::string structure;
  double distance = 0;  ///< mm from the catheter's wall, at most 20; negative: depth
  double length = 0;    ///< mm of the catheter whose wall is in the structure
  static const sim::Schema& schema();
};

/// Straight path of a catheter.
struct CatheterPath {
  glm::dvec3 start{0.0};                  ///< mm, world: where it met the outermost layer, or the given point
  glm::dvec3 tip{0.0};                    ///< mm, world
  double diameter = Catheter().diameter;  ///< mm
};
/// Returns the path of the catheter that a hand holds in the head. Without such a catheter, returns the path
/// of the newest passage, whose catheter was left in place or drawn out. Empty if no catheter has moved in
/// the head.
std::optional<CatheterPath> newest_path(const sim::OperationState& operation);

/// Passages of catheters, oldest first. Undo does not change them: brain is not restored.
struct CatheterPassages {
  static constexpr std::size_t k_max = 256;  ///< kept passages; older ones are only counted
  std::int64_t count = 0;
  std::vector<glm::dvec3> starts;      ///< mm, world: at the outermost layer
  std::vector<glm::dvec3> directions;  ///< unit, world: into the head
  std::vector<glm::dvec3> tips;        ///< mm, world: deepest known positions of the tips
  std::vector<double> hands;           ///< index of the hand of each passage
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
  double distance = 0, length = 0;  ///< mm, as in CatheterClearance
};
struct CatheterJudgement {
  CatheterJudged judged;
  std::vector<Crossing> crossings;    ///< in the order of the path
  std::vector<Clearance> clearances;  ///< of all forbidden structures other than dura, brain and ventricles
};
/// Judges a path. Requires that check_judging() accepts the request, that the scan has labels, and that
/// `item` of the request is a shape of the anatomy.
CatheterJudgement judge(const JudgeCatheter& request, const sim::JobInput& input);

const sim::JobType& judge_job();
/// Returns an error if `at` is empty and there is no catheter, if `at` has values other than two different
/// points, or if the trajectory is unknown.
Status check_judging(const JudgeCatheter& request, const sim::OperationState& operation);

}  // namespace trephine::ventriculostomy
