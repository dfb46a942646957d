// SurgicalPlan: plan of an operation on a scan: trajectories, landmarks, outlines, planes, targets, the
// procedure and limits of the score. World frame (LPS, mm).
#pragma once

#include <glm/vec3.hpp>
#include <string>
#include <vector>

#include "volume/base/error.h"
#include "volume/scan/procedure.h"

namespace trephine::volume {

/// Planned path of a tool, from its entry into the bone or skin to its end.
struct PlannedTrajectory {
  std::string name;
  glm::dvec3 entry_world{0.0}, target_world{0.0};
  double diameter = 0;        ///< of the tool, mm; 0: not planned
  std::string group = {};     ///< trajectories that belong together, such as "screws"; may be empty
  std::string side = {};      ///< "left", "right" or empty
  std::string vertebra = {};  ///< label of the vertebra, such as "L4"; may be empty
  friend bool operator==(const PlannedTrajectory&, const PlannedTrajectory&) = default;
};

/// A named point.
struct PlannedLandmark {
  std::string name;
  glm::dvec3 position_world{0.0};
  friend bool operator==(const PlannedLandmark&, const PlannedLandmark&) = default;
};

/// A closed line through points on a surface, such as that of a bone flap.
struct PlannedOutline {
  std::string name;
  std::vector<glm::dvec3> points_world;  ///< at least three, in order
  friend bool operator==(const PlannedOutline&, const PlannedOutline&) = default;
};

struct PlannedPlane {
  std::string name;
  glm::dvec3 point_world{0.0}, normal_world{0, 0, 1};  ///< the normal is a unit vector
  friend bool operator==(const PlannedPlane&, const PlannedPlane&) = default;
};

/// A structure that the operation should reach: a label of the scan.
struct PlannedTarget {
  std::string name, label;
  friend bool operator==(const PlannedTarget&, const PlannedTarget&) = default;
};

struct SurgicalPlan {
  std::vector<PlannedTrajectory> trajectories;
  std::vector<PlannedLandmark> landmarks;
  std::vector<PlannedOutline> outlines;
  std::vector<PlannedPlane> planes;
  std::vector<PlannedTarget> targets;
  SurgicalProcedure procedure;    ///< empty: no steps are required
  std::vector<ScoreLimit> score;  ///< limits of the case, which replace those of the procedure

  bool is_empty() const noexcept {
    return trajectories.empty() && landmarks.empty() && outlines.empty() && planes.empty() &&
           targets.empty() && procedure.is_empty() && score.empty();
  }
  friend bool operator==(const SurgicalPlan&, const SurgicalPlan&) = default;
};

/// Largest number of objects of each kind in a plan, and of points of an outline.
inline constexpr std::size_t k_max_planned = 256;
/// Returns the limits of the plan, and those of its procedure for all other findings.
std::vector<ScoreLimit> score_limits(const SurgicalPlan& plan);
/// Returns an error if names are missing or not unique, or if an object, a limit of the score or the
/// procedure is invalid. Targets are not compared with the labels of a scan.
Status check(const SurgicalPlan& plan);

}  // namespace trephine::volume
