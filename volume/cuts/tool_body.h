// ToolBody: cutting body of a tool, a convex body of revolution about its axis.
#pragma once

#include <glm/vec3.hpp>

#include "volume/base/error.h"

namespace trephine::volume {

/// Tool frame: `along` is the position on the axis in mm, which increases from the tip toward the shaft;
/// `off` is the distance from the axis in mm.
///
/// A cone is the convex hull of a ball of `radius` around 0 and one of `end_radius` around `length`: a ball,
/// a capsule, a match head. A drum is a cylinder between 0 and `length` whose side may bulge in an arc from
/// `end_radius` at both ends to `radius` in the middle, with edges rounded by `edge`: a cylinder, a barrel.
struct ToolBody {
  enum class Form : unsigned char { cone, drum };
  Form form = Form::cone;
  double radius = 1;      ///< mm
  double end_radius = 1;  ///< mm
  double length = 0;      ///< mm
  double edge = 0;        ///< mm, radius of a drum's rounded edges

  static ToolBody ball(double radius) noexcept { return {Form::cone, radius, radius, 0, 0}; }
  /// `length`: between the centres of the end balls, so the overall length is larger by both radii.
  static ToolBody cone(double radius, double end_radius, double length) noexcept {
    return {Form::cone, radius, end_radius, length, 0};
  }
  static ToolBody cylinder(double radius, double length, double edge) noexcept {
    return {Form::drum, radius, radius, length, edge};
  }
  static ToolBody barrel(double radius, double end_radius, double length, double edge) noexcept {
    return {Form::drum, radius, end_radius, length, edge};
  }

  bool is_ball() const noexcept { return form == Form::cone && length == 0; }
  /// Ends of the body along the axis, mm: at the tip (low) and toward the shaft (high).
  double low() const noexcept { return form == Form::cone ? -radius : 0; }
  double high() const noexcept { return form == Form::cone ? length + end_radius : length; }
  double middle() const noexcept { return 0.5 * (low() + high()); }
  /// Smallest radius, mm: a lattice that resolves a ball of this radius resolves the body, apart from the
  /// edges of a drum.
  double min_radius() const noexcept { return radius < end_radius ? radius : end_radius; }
  /// Radius of the bounding ball around `middle()` on the axis, mm.
  double reach() const noexcept;
  /// Exact signed distance in mm from a point to the surface; negative inside.
  double distance(double along, double off) const noexcept;
  /// Centre of a drum's rounded edge: `along` is the distance from the middle of the drum along the axis,
  /// `off` the distance from the axis, mm. `lean`: sine of the angle between the side's normal at the edge
  /// and the perpendicular to the axis.
  struct Corner {
    double along, off, lean;
  };
  Corner corner() const noexcept;
  /// Farthest point of the body in a direction, mm. `rise`: component of the unit direction along the axis
  /// (toward the shaft), -1 to 1. `off` is measured on the side of that direction.
  struct Support {
    double along, off;
  };
  Support support(double rise) const noexcept;
  /// Curvature of a drum's side, 1/mm; 0 if it is straight.
  double bulge() const noexcept;
};

/// Returns an error if a dimension is out of range, for example: a radius of 0, a length of 1 m, a drum whose
/// edges do not fit, a cone with one end ball inside the other.
Status check(const ToolBody& body);

/// Pose of a body, world frame.
struct ToolPose {
  glm::dvec3 at_world{0.0};              ///< origin of `along`, mm
  glm::dvec3 axis_world{0.0, 0.0, 1.0};  ///< unit vector toward the shaft
};

/// Interpolates two poses of a steady motion; `share` 0 (a) to 1 (b).
ToolPose between(const ToolPose& a, const ToolPose& b, double share) noexcept;

/// Sweep of a body that moves and turns from one pose to another.
struct ToolSweep {
  ToolBody body;
  ToolPose start, end;
  /// True if the editor already swept the body up to `start`.
  bool continues = false;
};

}  // namespace trephine::volume
