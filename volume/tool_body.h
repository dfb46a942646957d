// Cutting body of a tool: a convex body of revolution about its axis.
#pragma once

#include <glm/vec3.hpp>

#include "volume/error.h"

namespace trephine::volume {

/// In the tool's own frame: `along` is mm from the tip end of the body up its axis, toward the shaft.
///
/// A cone is the convex hull of a ball of `radius` around 0 and one of `end_radius` around `length`: a ball,
/// a capsule, a match head. A drum is a cylinder between 0 and `length`, whose side may bulge from
/// `end_radius` at both ends to `radius` in the middle (an arc), with edges rounded by `edge`: a cylinder, a
/// barrel.
struct ToolBody {
  enum class Form : unsigned char { cone, drum };
  Form form = Form::cone;
  double radius = 1;  ///< mm
  double end_radius = 1;
  double length = 0;  ///< mm
  double edge = 0;    ///< mm, of a drum

  static ToolBody ball(double radius) noexcept { return {Form::cone, radius, radius, 0, 0}; }
  /// The whole length of a round-ended one is `length` and two radii.
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
  /// mm along the axis where the body ends, beyond the tip and toward the shaft.
  double low() const noexcept { return form == Form::cone ? -radius : 0; }
  double high() const noexcept { return form == Form::cone ? length + end_radius : length; }
  double middle() const noexcept { return 0.5 * (low() + high()); }
  /// mm: a lattice that shows a ball of it shows the body.
  double least_radius() const noexcept { return radius < end_radius ? radius : end_radius; }
  /// From `middle()` on the axis to its farthest point.
  double reach() const noexcept;
  /// mm from a point `along` the axis and `off` it to the surface; negative inside. Exact.
  double distance(double along, double off) const noexcept;
  /// The middle of a drum's rounded edge, mm from the middle of its axis and off it, and the sine by which
  /// the
  /// side's normal leans along the axis there.
  struct Corner {
    double along, off, lean;
  };
  Corner corner() const noexcept;
  /// Its farthest point in a direction whose part along the axis (toward the shaft) is `rise`, -1 to 1: how
  /// far
  /// along the axis, and how far off it, on that side.
  struct Support {
    double along, off;
  };
  Support support(double rise) const noexcept;
  /// One over the radius of the circle whose arc a drum's side is, 1/mm; 0: straight.
  double bulge() const noexcept;
};

/// Error when a number is out of range: no body, a drum whose edges do not fit, a cone whose one ball lies in
/// the other.
Status check(const ToolBody& body);

/// Pose of a body, world frame.
struct ToolPlace {
  glm::dvec3 at_world{0.0};              ///< where `along` is 0, mm
  glm::dvec3 axis_world{0.0, 0.0, 1.0};  ///< unit, toward the shaft
};

/// Between two places, as a hand that moves steadily from one to the other: any share 0 to 1.
ToolPlace between(const ToolPlace& a, const ToolPlace& b, double share) noexcept;

/// A body moved from one place to another, turning on the way.
struct ToolSweep {
  ToolBody body;
  ToolPlace start, end;
  /// The body was swept to `start` before, in this editor's state.
  bool continues = false;
};

}  // namespace trephine::volume
