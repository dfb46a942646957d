// Evaluation of a bone flap: shape, exposure of a label, deviation from the plan, clearance of structures.
#pragma once

#include "modules/bone_flap/bone_flap.h"

namespace trephine::bone_flap {

/// Shape of an outline. All values except the perimeter are those of its projection along the flap's normal.
struct OutlineShape {
  double perimeter = 0;          ///< mm, along the skull
  double length = 0, width = 0;  ///< mm: longest extent, and the extent across it
  double roundness = 0;          ///< 1 for a circle, less for a long or jagged outline
};
OutlineShape shape_of(const FlapState& flap);

/// Exposure of a label: its projection along the normal, compared with the opening (the outline less half of
/// the saw's width).
struct LabelExposure {
  double share = 0;   ///< 0 to 1, of the projected area
  double margin = 0;  ///< mm, smallest distance of the projection from the opening's edge; negative: outside
  double depth = 0;   ///< mm from the outline's plane to the label's nearest voxel
  bool has_label = false;  ///< false: no voxel has the label
};
LabelExposure exposure_of(const FlapState& flap, const volume::Volume& scan, int label);

/// Clearance between the path of the saw, down to the inner table, and a structure that must not be cut. A
/// footplate keeps the saw away from matter below the bone, and strips this matter off the bone.
struct StructureClearance {
  std::string structure;
  double mm = sim::Forbidden::k_reach;  ///< clearance, at most k_reach; negative: depth of the cut into it
  glm::dvec3 at_world{0.0};             ///< position of the smallest clearance, mm
  double resolved = 0;                  ///< mm, resolution of the scan: 1.5 voxels of the structure
  /// True if saw and structure overlap by at most `resolved`. A membrane on the bone overlaps the blurred
  /// inner table by as much, and the footplate strips it. A structure that reaches deeper into the bone is
  /// cut.
  bool is_stripped() const noexcept { return mm < 0 && -mm <= resolved; }
};
std::vector<StructureClearance> clearances_of(
    const FlapState& flap, std::span<const std::shared_ptr<const sim::Forbidden>> forbidden);

/// Distance between two closed outlines, mm: the mean and the largest distance of points of one outline from
/// the other, over both directions.
struct OutlineDistance {
  double mean = 0, worst = 0;
};
OutlineDistance distance_between(const std::vector<glm::dvec3>& first, const std::vector<glm::dvec3>& second);
/// Returns the distance of a flap's outline from a planned one. Both are projected from the apex onto the
/// plane through the flap's centre: a plan has straight segments, and the saw follows the skull. If a point
/// of the plan is more than 60 degrees off the flap's normal, the distance is that in space.
OutlineDistance distance_from_plan(const FlapState& flap, const std::vector<glm::dvec3>& plan);
/// Returns the distance of a flap's outline from that outline of the plan that has the smallest mean
/// distance; nullopt if the plan has no outline.
std::optional<OutlineDistance> distance_from_nearest(const FlapState& flap, const volume::SurgicalPlan& plan);

}  // namespace trephine::bone_flap
