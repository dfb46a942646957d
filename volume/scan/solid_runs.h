// Run: interval of a solid on a line, to find the tables of a skull and the walls of a bone.
#pragma once

#include <glm/vec3.hpp>
#include <optional>
#include <vector>

#include "volume/scan/bone_labels.h"
#include "volume/scan/field.h"

namespace trephine::volume {

/// Interval of a solid on a line, mm from its start.
struct Run {
  double low, high;
};
/// Returns the runs of bone between t0 and t1, mm. Runs are joined across gaps of at most `space` mm and, if
/// `labels` is given, across gaps of any width inside a labelled bone. `along`: unit vector, world.
std::vector<Run> runs_along(const Field& bone, const glm::dvec3& start_world, const glm::dvec3& along,
                            double t0, double t1, double space, const BoneLabels* labels = nullptr);
/// Returns the run whose far end (`high`) is nearest to `t`; null if no far end is within `reach` mm of `t`.
const Run* nearest_run(const std::vector<Run>& runs, double t, double reach);

/// Bone of the skull through which a straight path leads, from the outside to the inside.
struct SkullCrossing {
  glm::dvec3 outer_world{0.0};  ///< mm, on the outer table
  glm::dvec3 inner_world{0.0};  ///< mm, on the inner table
  /// Unit normal, out of the head, of a plane fitted to points of the outer table on a circle of 8 mm radius
  /// around the path.
  glm::dvec3 normal_world{0, 0, 1};
  double thickness = 0;  ///< mm, along the path
};
/// Finds the first bone on a path from `from_world` (outside the head) along a unit direction within `reach`
/// mm: both tables and the diploe between them. Empty if there is no bone.
std::optional<SkullCrossing> skull_crossing(const Field& bone, const glm::dvec3& from_world,
                                            const glm::dvec3& along, double reach);

}  // namespace trephine::volume
