// Anatomical head phantom: a skull of two tables with diploe, orbits, sinuses and foramina; jaws, teeth,
// dura, venous sinus, brain, ventricles, a tumour, skin. Original shapes.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <optional>
#include <string_view>

namespace trephine::data_tools {

enum class HeadTissue : unsigned char {
  air,
  soft_tissue,
  cortical_bone,
  diploe,
  dura,
  cerebrospinal_fluid,
  brain,
  left_ventricle,
  tooth,
  venous_sinus,
  tumour,
  right_ventricle
};
inline constexpr const char* k_head_tissue_names[] = {
    "air",   "soft_tissue",    "cortical_bone", "diploe",       "dura",   "csf",
    "brain", "ventricle_left", "tooth",         "venous_sinus", "tumour", "ventricle_right"};
/// Surgical approach to a head: determines position and size of the tumour, and the planned opening.
enum class HeadApproach : unsigned char { vault, frontotemporal, suboccipital, keyhole };
inline constexpr std::string_view k_head_approach_names[] = {"vault", "frontotemporal", "suboccipital",
                                                             "keyhole"};
std::optional<HeadApproach> head_approach(std::string_view name) noexcept;

/// Variation of the head: seed 1 is the reference; others differ in size, thickness, sinuses and tumour.
struct HeadAnatomy {
  glm::dvec3 size{1.0};            ///< along each axis, relative to the reference; at most 1
  double thickness = 1;            ///< of the vault, relative to the reference
  double frontal_sinus = 1;        ///< size, relative to the reference
  glm::dvec3 tumour{-37, 14, 37};  ///< centre, mm, in a head of reference size
  double tumour_radius = 13;       ///< mm, in a head of reference size
  double opening_margin = 10;      ///< mm, planned margin of the opening around the tumour
};
/// Returns the anatomy of a seed; deterministic. For the approach `vault` the seed also determines the
/// tumour, which is on the left or on the right. The tumours of the other approaches are fixed, on the left.
HeadAnatomy head_anatomy(std::uint64_t seed, HeadApproach approach = HeadApproach::vault);

/// Point toward which approaches and their trajectories are directed, mm, in a head of reference size.
inline constexpr glm::dvec3 k_head_middle{0, -5, 0};

/// Box of the head, world mm (LPS; x toward the left, y toward the back, z up).
inline constexpr glm::dvec3 k_head_low{-86, -112, -124}, k_head_high{86, 104, 82};

/// Intensity (HU, without noise) and tissue at a world point.
struct HeadSample {
  double hounsfield;
  HeadTissue tissue;
  /// In open air: estimate of the distance to the skin, at most k_head_steepness times the true distance;
  /// elsewhere 0.
  double clear_mm;
};
/// Largest ratio of clear_mm, a first-order estimate, to the true distance.
inline constexpr double k_head_steepness = 3;
/// Samples the head; `voxel_mm` sets the width of partial-volume edges.
HeadSample sample_head(const glm::dvec3& p_world, double voxel_mm, const HeadAnatomy& anatomy) noexcept;

/// Returns the distance to the outer surface of the vault, mm, negative inside; first order.
double vault_distance(const glm::dvec3& p_world, const HeadAnatomy& anatomy) noexcept;
/// Returns the distance from a point inside the vault to its outer surface in a direction (unit), mm, at most
/// `farthest`; to 0.001 mm.
double distance_to_vault(const glm::dvec3& from_world, const glm::dvec3& direction, double farthest,
                         const HeadAnatomy& anatomy) noexcept;

}  // namespace trephine::data_tools
