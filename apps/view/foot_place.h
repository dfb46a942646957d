// FootPose: pose of a tool with a foot, and the searches for it: for a Kerrison under an edge of bone, for a
// craniotome in a burr hole.
#pragma once

#include <functional>
#include <glm/gtc/quaternion.hpp>
#include <glm/vec3.hpp>
#include <optional>
#include <string>
#include <vector>

namespace trephine::view {

/// Returns true if a world point is in bone.
using BoneTest = std::function<bool(const glm::dvec3& at_world)>;

/// Dimensions (mm) of a tool with a foot. Its frame: origin at the top of the foot, z along the shaft.
struct FootTool {
  enum class Kind { none, kerrison, craniotome } kind = Kind::none;
  double radius = 0;     ///< of the foot
  double thickness = 0;  ///< of the foot
  double opening = 0;    ///< Kerrison: distance between foot and jaw
  double jaw = 0;        ///< Kerrison: thickness of the jaw
  double bit = 0;        ///< craniotome: radius of the bit above the foot
  double length = 0;     ///< craniotome: length of the bit
  friend bool operator==(const FootTool&, const FootTool&) = default;
};

/// A pose of the tool at which its foot is free of bone.
struct FootPose {
  glm::dvec3 at_world{0.0};
  glm::dquat turn{1, 0, 0, 0};   ///< z along the shaft; Kerrison: x out of the bone, toward the open side
  std::vector<glm::dvec3> path;  ///< points to pass before the pose; the first is outside the bone
  std::vector<glm::dvec3> edge;  ///< Kerrison: line along the edge, on the surface
  glm::dvec3 edge_world{0.0};    ///< Kerrison: point of the edge
  double bone_thickness = 0;     ///< mm, of the bone above the foot
};

struct FootSearch {
  std::optional<FootPose> pose;
  std::string reason;  ///< reason and remedy if no pose was found
};

/// Finds the edge of bone, nearest to a point of the surface, under which the foot of a Kerrison fits. The
/// centre of the foot, below the bone, is then `reach` mm inward of the edge (negative: outside it). `shaft`:
/// unit, out of the bone. `open`: direction (unit) to the open side of the edge; 0: any. Cost: up to 50,000
/// calls of `is_bone`.
FootSearch find_edge(const BoneTest& is_bone, const FootTool& tool, const glm::dvec3& at_world,
                     const glm::dvec3& shaft, double reach, const glm::dvec3& open = glm::dvec3(0.0));

/// Returns the depth (mm along -shaft), below a point of the outer surface, of the upper face of a foot that
/// slides under the bone. The bone ends at the depth below which 3 mm are free of bone. Returns nullopt if it
/// does not end within 25 mm.
std::optional<double> foot_depth(const BoneTest& is_bone, const FootTool& tool, const glm::dvec3& at_world,
                                 const glm::dvec3& shaft);

/// Finds a pose within 8 mm of `at_world` at which a craniotome has its foot below the inner table, along
/// `shaft` (unit) or, in an oblique hole, tilted from it by up to 24 degrees. `at_world` is on the surface of
/// the bone as scanned, which `was_bone` describes.
FootSearch find_hole(const BoneTest& is_bone, const BoneTest& was_bone, const FootTool& tool,
                     const glm::dvec3& at_world, const glm::dvec3& shaft);

}  // namespace trephine::view
