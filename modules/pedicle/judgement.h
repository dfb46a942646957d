// JudgeScrew: a job that judges a screw: breach and grade, intensities around it, and distances to the plan.
#pragma once

#include "modules/pedicle/breach.h"
#include "modules/pedicle/placement.h"
#include "sim/api/forbidden.h"
#include "volume/scan/surgical_plan.h"

namespace trephine::pedicle {

/// Distances from which the two parts of a score (trajectory and depth) have no points, and the share of the
/// trajectory in the score.
struct ScoreMarks {
  double trajectory_zero = 20;    ///< mm, sum of the distances of entry and target to the plan
  double depth_zero = 10;         ///< mm, difference between the depth of the track and the screw's length
  double trajectory_share = 0.7;  ///< of the score
};

/// Job. It changes no anatomy.
struct JudgeScrew {
  sim::Id body = {};  ///< of the screw; 0: the last one
  /// Label of the vertebra. If it is empty, the screw is judged in the bone around `canal`, or without a
  /// position, in the labelled vertebra at the screw.
  std::string vertebra = {};
  /// At most one position in the vertebra's canal, mm, world; empty: the canal is searched for.
  std::vector<glm::dvec3> canal = {};
  std::int64_t item = 0;  ///< index of the bone's shape in the anatomy
  double trajectory_zero = ScoreMarks().trajectory_zero, depth_zero = ScoreMarks().depth_zero,
         trajectory_share = ScoreMarks().trajectory_share;
  ScoreMarks marks() const noexcept { return {trajectory_zero, depth_zero, trajectory_share}; }
  static const sim::Schema& schema();
};

enum class BodySide : std::uint8_t { left, right };
inline constexpr std::array<std::string_view, 2> k_side_names{"left", "right"};

/// A judgement. Emitted at `breach_at`.
struct ScrewJudged {
  sim::Id body;
  std::string vertebra;
  BodySide side = BodySide::left;
  double breach = 0;  ///< mm, of the pedicle; negative: least thickness of bone around the screw
  Wall wall = Wall::none;
  glm::dvec3 breach_at{0.0};  ///< mm, world: point of the largest breach or the thinnest bone
  double from_entry = 0;      ///< mm along the screw
  /// mm in front of the vertebra's body; negative: least thickness of bone; 0: the screw is not in the body.
  double front = 0;
  glm::dvec3 front_at{0.0};  ///< mm, world
  Grade grade = Grade::a;
  /// Grades if the bone were half a voxel larger or smaller: the grades that the scan cannot distinguish.
  Grade grade_of_larger = Grade::a, grade_of_smaller = Grade::a;
  double half_voxel = 0;                     ///< mm, in the direction of the breach
  bool is_uncertain = false;                 ///< these grades differ
  bool has_intensity = false;                ///< the scan is in Hounsfield units
  double core_hu = 0, shell_hu = 0;          ///< mean in the core, and in the millimetre around the thread
  std::string planned;                       ///< trajectory with the nearest entry; empty: no match
  double entry_error = 0, target_error = 0;  ///< mm, to the plan
  double angle_error = 0;                    ///< degrees
  bool has_track = false;
  double depth_error = 0;  ///< mm, length of the screw less depth of the track
  bool has_score = false;
  double score = 0;  ///< 0 to 100
  static const sim::Schema& schema();
};

/// Failure of a judgement. Emitted at the location of the problem.
struct ScrewNotJudged {
  std::string reason;
  static const sim::Schema& schema();
};

/// The newest judgement of each screw. Lists of equal lengths; `names` has one line per screw: "L4 left".
struct ScrewJudgements {
  std::vector<sim::Id> bodies;
  std::string names;
  std::vector<double> breaches, fronts, grades, scores;  ///< mm, mm, 0 (A) to 4, 0 to 100 or -1
  static const sim::Schema& schema();
};

/// Placed screw, and the depth of its track, with which a judgement compares the screw's length.
struct JudgedScrew {
  sim::Id body;
  Screw screw;
  std::optional<double> track_depth = std::nullopt;  ///< mm
};
/// A vertebra in its uncut state, in which screws are judged.
struct JudgedBone {
  std::shared_ptr<const volume::Volume> scan;
  std::string vertebra;  ///< its label; may be empty
  VertebraZones zones;
  std::shared_ptr<const sim::Forbidden> surface;
};
/// Finds the vertebra with this label. If `label` is -1, uses the bone of the shape `bone` around
/// `canal_world`, mm. Takes tenths of a second.
Result<JudgedBone, LocatedError> find_bone(const std::shared_ptr<const volume::Volume>& scan,
                                           const volume::Field& bone, int label,
                                           const glm::dvec3* canal_world);
/// Judges a screw. `plan` may be null.
Result<ScrewJudged, LocatedError> judge(const JudgedScrew& screw, const JudgedBone& bone,
                                        const volume::SurgicalPlan* plan, const ScoreMarks& marks);
/// Compares a screw with a planned trajectory: among those of the judged vertebra and, if `has_side`, of the
/// judged side, the one with the nearest entry. Sets its name, the distances to the plan and the score.
/// Changes nothing if the plan has no such trajectory.
void compare_with_plan(const JudgedScrew& screw, const volume::SurgicalPlan& plan, const ScoreMarks& marks,
                       bool has_side, ScrewJudged& judged);
/// Returns a placed screw with the depth of its track.
JudgedScrew judged_screw(const PedicleState& state, std::size_t index);

const sim::JobType& judge_job() noexcept;
/// Returns an error if the command names an unknown screw or several positions in the canal.
Status check_judging(const sim::Command& command, const sim::OperationState& operation);

}  // namespace trephine::pedicle
