// How a tool is drawn and changed by a window that knows none: by the table of its parameters.
#pragma once

#include <glm/vec2.hpp>
#include <vector>

#include "sim/value.h"

namespace trephine::view {

/// mm: half of its field "diameter"; 0 when it has none, which is drawn as a fine tip.
double drawn_radius(const sim::Value& parameters);
/// Its silhouette, as points to the right of its axis: mm along the axis from the tip's end, and off it. Of
/// the fields "diameter", "shape" (sphere, cylinder, barrel, match-head), "length"; empty where it has no
/// diameter. `cutting`: how far along the part goes that cuts; the rest is its shaft.
struct ToolOutline {
  std::vector<glm::dvec2> places;
  double cutting = 0;
};
ToolOutline outline_of(const sim::Value& parameters);
/// Its first number a step up or down, within its range: 0.5 of its unit. False when it has none.
bool step_first_number(sim::Value& parameters, int steps);

}  // namespace trephine::view
