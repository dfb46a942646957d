// Finds where a tool with a foot goes: a Kerrison's foot under an edge of bone, a craniotome's into a burr
// hole.
#pragma once

#include <functional>
#include <glm/gtc/quaternion.hpp>
#include <glm/vec3.hpp>
#include <optional>
#include <string>
#include <vector>

namespace trephine::view {

/// Returns whether a place of the world is in bone.
using BoneTest = std::function<bool(const glm::dvec3& at_world)>;

/// A tool with a foot, mm. The hand holds the top of the foot; z leads up the shaft.
struct FootTool {
  enum class Kind { none, kerrison, craniotome } kind = Kind::none;
  double radius = 0;     ///< of the foot
  double thickness = 0;  ///< of the foot
  double opening = 0;    ///< Kerrison: between foot and jaw
  double jaw = 0;        ///< Kerrison: thickness of the jaw
  double bit = 0;        ///< craniotome: radius of the bit that stands on the foot
  double length = 0;     ///< craniotome: length of the bit
  friend bool operator==(const FootTool&, const FootTool&) = default;
};

/// A place of the hand at which the foot is free.
struct FootPlace {
  glm::dvec3 at_world{0.0};
  glm::dquat turn{1, 0, 0, 0};   ///< z up the shaft; Kerrison: x out of the bone, toward the open side
  std::vector<glm::dvec3> way;   ///< places to pass before it; the first is outside
  std::vector<glm::dvec3> edge;  ///< Kerrison: a line along the edge, on the surface
  glm::dvec3 edge_world{0.0};    ///< Kerrison: the place of the edge
  double bone_thickness = 0;     ///< mm, above the foot
};

struct FootSearch {
  std::optional<FootPlace> place;
  std::string why;  ///< the reason and the remedy, where there is no place
};

/// Looks for the nearest edge around a place on the surface under which the foot of a Kerrison fits, `reach`
/// mm beyond it (its middle; negative: before the edge). `shaft`: unit, out of the bone. Asks
/// `is_bone` up to 50,000 times. `open`: unit, the side on which the edge is open; 0: any.
FootSearch find_edge(const BoneTest& is_bone, const FootTool& tool, const glm::dvec3& at_world,
                     const glm::dvec3& shaft, double reach, const glm::dvec3& open = glm::dvec3(0.0));

/// Returns how far below a place on the outer surface the top of a foot is that slides under the bone, mm
/// along -shaft; bone ends where a stretch of 3 mm without any follows. Nothing within 25 mm: no value.
std::optional<double> foot_depth(const BoneTest& is_bone, const FootTool& tool, const glm::dvec3& at_world,
                                 const glm::dvec3& shaft);

/// Looks for a place within 8 mm of `at_world` at which a craniotome stands upright with its foot below the
/// inner table. `at_world` is on the surface as it was before anything was removed, which `was_bone`
/// describes.
FootSearch find_hole(const BoneTest& is_bone, const BoneTest& was_bone, const FootTool& tool,
                     const glm::dvec3& at_world, const glm::dvec3& shaft);

}  // namespace trephine::view
