// Head in a skull clamp: the solid of the head with its scalp, and the parts of the clamp that are in the
// head.
#pragma once

#include <array>

#include "modules/skull_clamp/clamp_surface.h"
#include "volume/scan/field.h"

namespace trephine::skull_clamp {

/// The head as a solid: all labelled voxels if a label is named scalp, skin or soft_tissue; else tissue of a
/// CT in Hounsfield units; else the bone alone. Borrows the field.
class HeadSolid {
 public:
  explicit HeadSolid(const volume::Field& bone);
  /// Returns true if the scan shows the surface of the head, and not only that of the bone.
  bool has_skin() const noexcept { return kind_ != Kind::bone; }
  bool contains(const glm::dvec3& p_world) const noexcept;
  /// Returns the thickness of tissue from a point of the outer table outward, mm, at most `reach`. Gaps of up
  /// to 1 mm count as tissue.
  double thickness(const glm::dvec3& table_world, const glm::dvec3& outward, double reach) const noexcept;

 private:
  enum class Kind { labels, intensities, bone };
  const volume::Field& bone_;
  Kind kind_ = Kind::bone;
};

/// Overlap of arms and rocker with the head.
struct HeadContact {
  /// Greatest depth of a surface point of arms or rocker below the surface of the head, mm: in steps of 0.5,
  /// at most 60. 0: no contact.
  double depth = 0;
  double length = 0;         ///< mm of arms and rocker whose surface is in the head
  glm::dvec3 at_world{0.0};  ///< mm, the deepest point; valid if depth > 0
};
HeadContact head_contact(const HeadSolid& head, std::span<const ClampRod> rods);

}  // namespace trephine::skull_clamp
