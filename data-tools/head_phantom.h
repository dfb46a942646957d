// The anatomical head: a skull of two tables with diploe, orbits, sinuses and foramina, jaws and teeth; dura,
// venous sinus, brain, ventricles, a tumour, skin. Original shapes.
#pragma once

#include <cstdint>
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
  tooth,
  venous_sinus,
  tumour
};
inline constexpr const char* k_head_tissue_names[] = {"air",   "soft_tissue",  "cortical_bone", "diploe",
                                                      "dura",  "csf",          "brain",         "ventricle",
                                                      "tooth", "venous_sinus", "tumour"};

/// One anatomy: seed 1 is the plain one, others differ in size, thickness, sinuses and where the tumour lies.
struct HeadAnatomy {
  glm::dvec3 size{1.0};            ///< of the plain one, along each axis; at most 1
  double thickness = 1;            ///< of the vault, of the plain one's
  double frontal_sinus = 1;        ///< of its size
  glm::dvec3 tumour{-37, 14, 37};  ///< mm, in a head of plain size
  double tumour_radius = 13;
};
HeadAnatomy head_anatomy(std::uint64_t seed);

/// Box of the head, world mm (LPS; x toward the left, y toward the back, z up).
inline constexpr glm::dvec3 k_head_low{-86, -112, -124}, k_head_high{86, 104, 82};

/// Intensity (HU, without noise) and tissue at a world point; `voxel_mm` sets the width of partial-volume
/// edges.
struct HeadSample {
  double hounsfield;
  HeadTissue tissue;
  double clear_mm;  ///< in open air: about how far the skin is, up to a factor of k_head_steepness; else 0
};
/// Ratio of the skin's measure to distance: it is of first order.
inline constexpr double k_head_steepness = 3;
HeadSample sample_head(const glm::dvec3& p_world, double voxel_mm, const HeadAnatomy& anatomy) noexcept;

/// To the vault's outside, mm, negative inside; of first order.
double vault_distance(const glm::dvec3& p_world, const HeadAnatomy& anatomy) noexcept;

}  // namespace trephine::data_tools
