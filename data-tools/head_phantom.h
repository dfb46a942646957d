// The anatomical head: a skull of two tables with diploe, jaws and teeth, dura, brain and skin. Original
// shapes.
#pragma once

#include <glm/vec3.hpp>

namespace trephine::data_tools {

enum class HeadTissue : unsigned char {
  air,
  soft_tissue,
  cortical_bone,
  diploe,
  dura,
  cerebrospinal_fluid,
  brain,
  ventricle,
  tooth
};
inline constexpr const char* k_head_tissue_names[] = {"air", "soft_tissue", "cortical_bone", "diploe", "dura",
                                                      "csf", "brain",       "ventricle",     "tooth"};

/// Box of the head, world mm (LPS; x toward the left, y toward the back, z up).
inline constexpr glm::dvec3 k_head_low{-86, -112, -124}, k_head_high{86, 104, 82};

/// Intensity (HU, without noise) and tissue at a world point; `voxel_mm` sets the width of partial-volume
/// edges.
struct HeadSample {
  double hounsfield;
  HeadTissue tissue;
  double clear_mm;  ///< in open air: about how far the skin is, up to a factor of k_head_steepness; else 0
};
/// How much faster than distance the skin's measure grows: it is of first order.
inline constexpr double k_head_steepness = 3;
HeadSample sample_head(const glm::dvec3& p_world, double voxel_mm) noexcept;

}  // namespace trephine::data_tools
