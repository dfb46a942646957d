// Evaluation of a flap: what it uncovers, its distance to the plan, and to structures along the saw.
#pragma once

#include "modules/bone_flap/bone_flap.h"

namespace trephine::bone_flap {

/// An outline as seen along its normal.
struct OutlineShape {
  double perimeter = 0;          ///< mm, along the skull
  double length = 0, width = 0;  ///< mm: its longest extent, and that across it
  double roundness = 0;          ///< 1 for a circle, less for what is long or jagged
};
OutlineShape shape_of(const FlapWorld& flap);

/// Share of a label's shadow along the normal within the opening (the outline less half of the saw).
struct Cover {
  double share = 0;   ///< 0 to 1, of the shadow's area
  double margin = 0;  ///< mm from the shadow's edge to the opening's, at the worst; below 0: beyond it
  double depth = 0;   ///< mm from the outline's plane to the label's nearest voxel
  bool is_any = false;
};
Cover cover_of(const FlapWorld& flap, const volume::Volume& scan, int label);

/// Distance of the saw from a structure that must not be cut, along its lines down to the inner table: a
/// footplate keeps it from what lies below, which is stripped off the bone.
struct Near {
  std::string structure;
  double mm = sim::Forbidden::k_reach;  ///< at most that; negative: so deep it goes into it
  glm::dvec3 at_world{0.0};             ///< where
  double resolved = 0;                  ///< mm that the scan resolves: 1.5 of the structure's voxels
  /// A membrane that lies against the bone overlaps its blurred inner table by less than the scan resolves:
  /// the footplate strips it. What stands in the bone by more is cut.
  bool is_stripped() const noexcept { return mm < 0 && -mm <= resolved; }
};
std::vector<Near> nearness_of(const FlapWorld& flap,
                              std::span<const std::shared_ptr<const sim::Forbidden>> forbidden);

/// Between two closed outlines, mm: the mean of either's places from the other, and the worst.
struct OutlineDistance {
  double mean = 0, worst = 0;
};
OutlineDistance distance_between(const std::vector<glm::dvec3>& one, const std::vector<glm::dvec3>& other);
/// The flap's from an outline that was planned, both as its apex sees them on the plane through its middle: a
/// plan's anchors are joined straight, and the saw follows the skull.
OutlineDistance distance_from_plan(const FlapWorld& flap, const std::vector<glm::dvec3>& plan);

}  // namespace trephine::bone_flap
