// Appearance and controls of a tool that the window does not know: by the table of its parameters.
#pragma once

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <vector>

#include "apps/view/foot_place.h"
#include "sim/value.h"

namespace trephine::view {

/// A part of a tool: a silhouette that is turned around its axis.
struct ToolPart {
  std::vector<glm::dvec2> profile;     ///< mm along the axis, and off it
  glm::dvec3 at{0.0}, along{0, 0, 1};  ///< where the axis begins, and where it leads
  bool is_cutting = true;
  bool is_fluted = false;  ///< it turns, and cuts with flutes that wind around it
  friend bool operator==(const ToolPart&, const ToolPart&) = default;
};

/// A tool as it is drawn. Its frame is the hand's: the hand holds its origin, z leads up its shaft.
struct ToolLook {
  std::vector<ToolPart> parts;
  double radius = 0;          ///< mm, of what cuts: half of its diameter, or of its jaws' width
  bool is_ball = true;        ///< the hand holds a ball's middle: it looks the same however it is held
  double shaft_from = 0;      ///< mm along z, where the shaft begins ...
  double shaft_radius = 0.5;  ///< ... and how thick that is
  FootTool foot;              ///< of kind none where it has none
};

/// Look from the fields "diameter", "shape" (sphere, cylinder, barrel, match-head), "length"; with a "foot",
/// below it; with an "inner" and its "lead", ahead of it; of "width", "opening" and "jaw", two jaws. What has
/// none of them is a fine tip, of radius 0 and without parts.
ToolLook look_of(const sim::Value& parameters);
ToolLook ball_look(double radius);
/// mm: half of its field "diameter"; 0 when it has none.
double drawn_radius(const sim::Value& parameters);
/// Its first number a step up or down, within its range: 0.5 of its unit. False when it has none.
bool step_first_number(sim::Value& parameters, int steps);

}  // namespace trephine::view
