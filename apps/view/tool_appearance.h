// ToolAppearance: appearance of a tool, derived from the table of its parameters.
#pragma once

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <optional>
#include <vector>

#include "apps/view/foot_place.h"
#include "sim/api/value.h"
#include "volume/surface/lathe.h"

namespace trephine::view {

/// A part of a tool: a solid of revolution.
struct ToolPart {
  std::vector<glm::dvec2> profile;     ///< mm along the axis, mm from the axis
  glm::dvec3 at{0.0}, along{0, 0, 1};  ///< start (mm) and direction (unit) of the axis
  bool is_cutting = true;
  bool is_fluted = false;  ///< a rotating part with helical flutes
  friend bool operator==(const ToolPart&, const ToolPart&) = default;
};

/// Appearance of a tool, in the frame of the hand: the origin is the held point, z points along the shaft.
struct ToolAppearance {
  std::vector<ToolPart> parts;
  double radius = 0;          ///< half of the cutter's diameter or of the jaws' width, mm
  bool is_ball = true;        ///< a ball held at its centre, which looks the same in every orientation
  double shaft_from = 0;      ///< start of the shaft along z, mm
  double shaft_radius = 0.5;  ///< mm
  FootTool foot;              ///< Kind::none for tools without a foot
  double insertion = 0;       ///< length that is inserted along the shaft, mm; 0: the tool is not inserted
  bool is_drill = false;      ///< an inserted tool that drills its own hole
};

/// Derives the look from the fields "diameter", "shape" (sphere, cylinder, barrel, match-head) and "length";
/// a "foot" adds a foot below the bit, "inner" and "lead" a drill ahead of it; "diameter" and "length"
/// alone give a probe, "width", "opening" and "jaw" two jaws. Without these fields the tool is a fine tip of
/// radius 0 without parts.
ToolAppearance appearance_of(const sim::Value& parameters);
ToolAppearance ball_appearance(double radius);
/// Returns the closed surface of a tool's end and shaft as solids of revolution, for X-rays, in the frame of
/// the hand; nullopt for a tool without parts.
std::optional<volume::TurnedSolid> solid_of(const ToolAppearance& tool);
/// Half of the field "diameter", mm; 0 without that field.
double drawn_radius(const sim::Value& parameters);
/// Changes the first number field by 0.5 of its unit per step, within its range. Returns false if there is no
/// such field.
bool step_first_number(sim::Value& parameters, int steps);

}  // namespace trephine::view
