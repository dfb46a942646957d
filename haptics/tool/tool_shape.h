// ToolShape: geometry with which a hand touches: a point, a ball, a rigid set of balls, or a surface.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <memory>
#include <span>
#include <vector>

#include "volume/base/error.h"

namespace trephine::haptics {

class MeshTree;
class PointShell;
using SharedShell = std::shared_ptr<const PointShell>;

/// A body of revolution about the z axis of the hand, and the spacing of the points that represent it.
struct ToolProfile {
  /// A circle about the axis.
  struct Ring {
    double along = 0;   ///< mm, from the HIP toward the hand
    double radius = 0;  ///< mm
    friend bool operator==(const Ring&, const Ring&) = default;
  };
  static constexpr std::size_t k_max_rings = 256;
  std::vector<Ring> rings;  ///< from the tip toward the hand; a disk closes each end
  double spacing = 0.25;    ///< mm
  friend bool operator==(const ToolProfile&, const ToolProfile&) = default;
};

/// Degrees of freedom of a contact: three for positions, six with orientations.
enum class Freedom : std::uint8_t { three, six };

/// Geometry of a tool, in the frame of the hand. Immutable; scenes of several hands may share it.
class ToolShape {
 public:
  enum class Kind : std::uint8_t {
    point,  ///< at the HIP
    ball,   ///< with its centre at the HIP
    balls,  ///< a rigid set of one or more balls, which rotates with the hand
    shell,  ///< points of a rigid surface, which rotates with the hand
  };
  struct Ball {
    glm::dvec3 centre{0.0};  ///< mm, frame of the hand
    double radius = 0;       ///< mm
    friend bool operator==(const Ball&, const Ball&) = default;
  };
  static constexpr std::size_t k_max_balls = 16;

  ToolShape() noexcept = default;  ///< a point
  /// A ball at the HIP; a radius (mm) of 0 is a point. The radius is not checked.
  explicit ToolShape(double radius_mm);
  /// A rigid set of at least one ball. Number and sizes of the balls are not checked.
  explicit ToolShape(std::vector<Ball> balls);
  /// The surface of a rigid tool. Requires a shell.
  explicit ToolShape(SharedShell shell);
  /// The surface of a body of revolution, without points; sample_surface() returns the tool with points. The
  /// profile is not checked.
  explicit ToolShape(ToolProfile profile);
  /// The surface of a body of revolution, with its points.
  ToolShape(ToolProfile profile, SharedShell shell);
  /// The surface of a closed mesh, with its points.
  ToolShape(std::shared_ptr<const MeshTree> mesh, SharedShell shell);

  Kind kind() const noexcept { return kind_; }
  bool is_point() const noexcept { return kind_ == Kind::point; }
  Freedom freedom() const noexcept {
    return kind_ == Kind::balls || kind_ == Kind::shell ? Freedom::six : Freedom::three;
  }
  bool is_six_dof() const noexcept { return freedom() == Freedom::six; }
  /// Returns the radius of the largest ball, mm; 0 for a point or a shell.
  double radius() const noexcept { return radius_; }
  bool has_equal_radii() const noexcept { return has_equal_radii_; }
  /// Returns the balls of a rigid set; empty for the other kinds.
  std::span<const Ball> balls() const noexcept { return balls_; }
  /// Returns the points of a shell; null for the other kinds, and for a profile without points (see
  /// sample_surface()).
  const SharedShell& shell() const noexcept { return shell_; }
  /// Returns the profile of a body of revolution; without rings for other tools.
  const ToolProfile& profile() const noexcept { return profile_; }
  /// Returns the mesh whose surface touches, in the frame of the hand; null for other tools.
  const std::shared_ptr<const MeshTree>& mesh() const noexcept { return mesh_; }
  /// Returns the centres of balls().
  std::vector<glm::dvec3> centres() const;
  /// Returns the largest distance of a ball's centre or a shell's point from the HIP, mm. A rotation about
  /// the HIP moves no centre or point on a larger circle.
  double arm() const noexcept { return arm_; }
  /// Returns the distance of the tool's farthest point from the HIP, mm.
  double extent() const noexcept { return extent_; }
  /// Returns the ratio of rotational to translational stiffness between the hand and the tool, mm2, as if
  /// each ball or point had a spring of its own; at least 400.
  double gyration_square() const noexcept { return gyration_square_; }
  /// Returns a hash that distinguishes shapes: of the balls, of the profile, or of the points of a shell
  /// without a profile.
  std::uint64_t fingerprint() const noexcept;
  friend bool operator==(const ToolShape& a, const ToolShape& b) noexcept {
    return a.kind_ == b.kind_ && a.radius_ == b.radius_ && a.balls_ == b.balls_ && a.profile_ == b.profile_ &&
           (!a.profile_.rings.empty() || a.shell_hash_ == b.shell_hash_);
  }

 private:
  // mm2. The rotational stiffness of the hand is at least that of springs 20 mm from the HIP on each side.
  // With only a spring per ball, the bit of a craniotome tilts below the bone until it is caught in the burr
  // hole.
  static constexpr double k_least_gyration_square = 400;

  Kind kind_ = Kind::point;
  bool has_equal_radii_ = true;
  double radius_ = 0, arm_ = 0, extent_ = 0, gyration_square_ = k_least_gyration_square;
  std::vector<Ball> balls_;
  ToolProfile profile_;
  std::shared_ptr<const MeshTree> mesh_;
  SharedShell shell_;
  std::uint64_t shell_hash_ = 0;  ///< 0: no shell
};

using SharedTool = std::shared_ptr<const ToolShape>;

/// Returns an error if a rigid set has too many balls, or a ball without a radius or too far from the HIP, or
/// if a profile encloses no solid. Tools of the kinds point and ball are always valid.
Status check(const ToolShape& tool);

/// Returns the tool with the points of its surface; the tool itself if it already has points, or is not a
/// shell. Error if the profile is invalid, or needs too many points. Takes about 20 ms for 10^4 points.
Result<SharedTool> sample_surface(const SharedTool& tool);

/// Makes a tool of the surface of a closed mesh, whose coordinates are in the frame of the hand, mm: the HIP
/// is the origin, and the shaft points along z. Error if the mesh is open or empty, faces inward, is farther
/// than 300 mm from the HIP, or needs too many points (PointShell).
Result<SharedTool> make_tool(std::shared_ptr<const MeshTree> mesh, double spacing_mm);
/// Makes a rigid tool of balls of one radius (mm) at these centres (mm, frame of the hand); no centres: a
/// ball at the HIP, or a point if the radius is 0. Error if the balls form no valid tool.
Result<SharedTool> make_tool(double radius_mm, std::span<const glm::dvec3> centres = {});
/// Makes a rigid tool of balls, each of its own radius; no balls: a point. Error if the balls form no valid
/// tool.
Result<SharedTool> make_tool(std::vector<ToolShape::Ball> balls);

}  // namespace trephine::haptics
