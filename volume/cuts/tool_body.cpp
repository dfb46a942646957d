#include "volume/cuts/tool_body.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <string>

#include "volume/base/axes.h"
#include "volume/base/text.h"

namespace trephine::volume {

double ToolBody::reach() const noexcept {
  const double half = 0.5 * (high() - low());
  return form == Form::cone ? half : std::sqrt(half * half + radius * radius);
}

double ToolBody::bulge() const noexcept {
  const double sagitta = radius - end_radius, half = 0.5 * length;
  return form == Form::drum && sagitta > 0 ? 2 * sagitta / (half * half + sagitta * sagitta) : 0;
}

ToolBody::Corner ToolBody::corner() const noexcept {
  const double along = 0.5 * length - edge, k = bulge();
  if (k == 0) return {along, radius - edge, 0};
  const double arc = 1 / k - edge;  // radius of the side's arc, offset inward by the edge radius
  return {along, std::sqrt(std::max(0.0, arc * arc - along * along)) - (1 / k - radius), along / arc};
}

ToolBody::Support ToolBody::support(double rise) const noexcept {
  const double radial = std::sqrt(std::max(0.0, 1 - rise * rise));
  if (form == Form::cone) {
    const bool is_end = length * rise + end_radius > radius;
    const double ball = is_end ? end_radius : radius;
    return {(is_end ? length : 0) + ball * rise, ball * radial};
  }
  const Corner at = corner();
  const double k = bulge(), half = 0.5 * length;
  if (std::abs(rise) > at.lean || k == 0)
    return {half + (rise < 0 ? -at.along : rise > 0 ? at.along : 0) + edge * rise, at.off + edge * radial};
  return {half + rise / k, radial / k - (1 / k - radius)};
}

double ToolBody::distance(double along, double off) const noexcept {
  if (form == Form::cone) {
    // Finds the nearest of the balls between both ends.
    double share = 0;
    if (length > 0) {
      const double taper = (radius - end_radius) / length;
      const double slope = taper / std::sqrt(1 - taper * taper);
      share = std::clamp((along - slope * off) / length, 0.0, 1.0);
    }
    const double axial = along - share * length;
    return std::sqrt(off * off + axial * axial) - (radius + share * (end_radius - radius));
  }
  // Computes the distances to the cap and to the side after an inward offset of both by the edge radius.
  // Between the normals of cap and side, the rounded edge is nearest.
  const double half = 0.5 * length, k = bulge(), u = off - radius, s = std::abs(along - half);
  const double square = s * s + u * u;
  const double side = (k * square + 2 * u) / (std::sqrt(k * k * square + 2 * u * k + 1) + 1) + edge;
  const Corner at = corner();
  const double vs = s - at.along, vo = off - at.off;
  if (vo > 0 && vs * std::sqrt(1 - at.lean * at.lean) - vo * at.lean > 0)
    return std::sqrt(vs * vs + vo * vo) - edge;
  return std::max(vs, side) - edge;
}

Status check(const ToolBody& body) {
  const auto bad = [](const char* dimension, const std::string& found, const char* expected) {
    return Error{.what = "invalid tool body", .where = dimension, .found = found, .expected = expected};
  };
  if (!(body.radius > 0) || !(body.radius < 1e3))
    return bad("radius", rounded_text(body.radius), "above 0, below 1000 mm");
  if (!(body.length >= 0) || !(body.length < 1e3))
    return bad("length", rounded_text(body.length), "0 or more, below 1000 mm");
  if (body.form == ToolBody::Form::cone) {
    if (!(body.end_radius > 0) || !(body.end_radius < 1e3))
      return bad("end radius", rounded_text(body.end_radius), "above 0, below 1000 mm");
    const bool is_ball = body.length == 0 && body.radius == body.end_radius;
    if (!is_ball && !(std::abs(body.radius - body.end_radius) < body.length))
      return bad("length", rounded_text(body.length), "more than the difference of the radii");
    return std::nullopt;
  }
  if (!(body.edge >= 0) || !(2 * body.edge < body.length) || !(body.edge < body.end_radius))
    return bad("edge", std::to_string(body.edge),
               "0 or more, less than half the length and less than the end radius");
  if (!(body.end_radius > 0) || !(body.end_radius <= body.radius) ||
      !(body.radius - body.end_radius <= 0.5 * body.length))
    return bad("end radius", rounded_text(body.end_radius),
               "above 0, at most the radius, at least the radius minus half the length");
  return std::nullopt;
}

ToolPose between(const ToolPose& a, const ToolPose& b, double share) noexcept {
  const glm::dvec3 at = a.at_world + share * (b.at_world - a.at_world);
  const double cosine = glm::dot(a.axis_world, b.axis_world);
  if (cosine < 0) {
    // The axis turns by more than a quarter turn: interpolates through the bisecting axis. For half a turn
    // the bisecting axis is not unique; then uses an axis perpendicular to the first.
    const glm::dvec3 sum = a.axis_world + b.axis_world;
    glm::dvec3 mid;
    if (glm::dot(sum, sum) > 1e-12) {
      mid = glm::normalize(sum);
    } else {
      const glm::dvec3 other = non_parallel_axis(a.axis_world);
      mid = glm::normalize(glm::cross(a.axis_world, other));
    }
    const bool is_first = share < 0.5;
    const glm::dvec3& from = is_first ? a.axis_world : mid;
    const glm::dvec3& to = is_first ? mid : b.axis_world;
    const double part = is_first ? 2 * share : 2 * share - 1;
    return {at, glm::normalize(from + part * (to - from))};
  }
  return {at, glm::normalize(a.axis_world + share * (b.axis_world - a.axis_world))};
}

}  // namespace trephine::volume
