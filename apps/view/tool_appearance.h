// ToolAppearance: appearance of a tool, derived from the table of its parameters.
#pragma once

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "apps/view/foot_place.h"
#include "sim/api/value.h"
#include "volume/surface/lathe.h"

namespace trephine::haptics {
class MeshTree;
}

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
  bool has_shaft = true;      ///< shaft and handle are drawn beyond the parts
  std::shared_ptr<const haptics::MeshTree> mesh = nullptr;  ///< drawn instead of parts
  FootTool foot;                                            ///< Kind::none for tools without a foot
  double insertion = 0;   ///< greatest inserted length, mm; 0: a tool that cannot be inserted
  bool is_drill = false;  ///< an inserted tool that drills its own hole
};

/// Returns the appearance of a tool, derived from these fields of its parameters:
/// - "diameter", "shape" (sphere, cylinder, barrel, match-head) and "length": a burr;
/// - "diameter", "length" and "foot": a craniotome, with a foot below its bit;
/// - "diameter", "inner" and "lead": a perforator, whose inner drill is ahead of the outer one;
/// - "diameter" and a greater "length", without "shape": a probe;
/// - "width", "opening" and "jaw": a rongeur with two jaws, or a Kerrison if "kind" is kerrison.
/// Without these fields the tool is a point of radius 0 without parts.
ToolAppearance appearance_of(const sim::Value& parameters);
ToolAppearance ball_appearance(double radius);
/// Returns the appearance of a tool whose whole surface touches: of a mesh, or if that is null, of a body of
/// revolution. `profile`: its position along the axis and radius, mm, from the tip toward the hand.
ToolAppearance surface_appearance(std::shared_ptr<const haptics::MeshTree> mesh,
                                  std::span<const glm::dvec2> profile);
/// Returns a closed solid of revolution that approximates a tool's end and shaft in X-rays, in the frame of
/// the hand; nullopt for a tool without parts.
std::optional<volume::TurnedSolid> solid_of(const ToolAppearance& tool);
/// Returns half of the field "diameter", mm; 0 without that field.
double drawn_radius(const sim::Value& parameters);
/// Changes the first number field by 0.5 of its unit per step. The number stays in its range and is at least
/// 0.5. Returns false if there is no number field.
bool step_first_number(sim::Value& parameters, int steps);

}  // namespace trephine::view
