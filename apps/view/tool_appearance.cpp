#include "apps/view/tool_appearance.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <string_view>

namespace trephine::view {

using glm::dvec2;
using glm::dvec3;

namespace {

constexpr double k_right_angle = 1.5707963267948966;

/// Parameters of a tool that determine its appearance.
struct Fields {
  explicit Fields(const sim::Value& tool) {
    if (tool.is_empty()) return;
    for (const sim::Field& field : tool.schema().fields) {
      // pointer_in() takes a mutable struct; nothing is written here.
      const auto pointer = field.pointer_in(const_cast<void*>(tool.data()));
      if (auto* const* number = std::get_if<double*>(&pointer))
        for (const auto& [name, value] : numbers)
          if (name == field.name) *value = **number;
      if (auto* const* choice = std::get_if<std::uint8_t*>(&pointer);
          choice && **choice < field.info.choices.size()) {
        if (field.name == "shape") shape = field.info.choices[**choice];
        if (field.name == "kind") kind = field.info.choices[**choice];
        if (field.name == "guide") guide = field.info.choices[**choice];
      }
    }
  }
  double diameter = 0, length = 0, foot = 0, inner = 0, lead = 0, width = 0, opening = 0, jaw = 0;
  std::string_view shape, kind, guide;

 private:
  const std::pair<std::string_view, double*> numbers[8]{
      {"diameter", &diameter}, {"length", &length}, {"foot", &foot},       {"inner", &inner},
      {"lead", &lead},         {"width", &width},   {"opening", &opening}, {"jaw", &jaw}};
};

/// Adds an arc between two angles (rad) to a profile. The centre of the arc is `middle` mm along the axis and
/// `offset` mm from it; angle 0 is the lowest point of the arc.
void add_arc(std::vector<dvec2>& profile, double middle, double radius, double from, double to,
             double offset = 0) {
  constexpr int k_steps = 12;
  for (int i = 0; i <= k_steps; ++i) {
    const double a = from + (to - from) * i / k_steps;
    profile.push_back({middle - radius * std::cos(a), offset + radius * std::sin(a)});
  }
}

ToolPart disc(double from, double to, double radius, bool is_cutting = true) {
  return {{{from, 0}, {from, radius}, {to, radius}, {to, 0}}, dvec3(0), {0, 0, 1}, is_cutting};
}
ToolPart rod(const dvec3& from, const dvec3& to, double radius) {
  ToolPart part = disc(0, glm::length(to - from), radius, false);
  part.at = from;
  part.along = glm::normalize(to - from);
  return part;
}

ToolPart drum(double radius, double end_radius, double length) {
  ToolPart part;
  part.is_fluted = true;
  const double edge = 0.1 * std::min(radius, length);
  part.profile.push_back({0, 0});
  add_arc(part.profile, edge, edge, 0, k_right_angle, end_radius - edge);
  constexpr int k_steps = 12;
  for (int i = 1; i < k_steps; ++i) {
    const double t = static_cast<double>(i) / k_steps;
    part.profile.push_back(
        {edge + t * (length - 2 * edge), end_radius + (radius - end_radius) * 4 * t * (1 - t)});
  }
  for (const dvec2& p :
       {dvec2(length - edge, end_radius), dvec2(length, end_radius - edge), dvec2(length, 0)})
    part.profile.push_back(p);
  return part;
}

/// Returns a rod whose round end has its lowest point `tip` mm along the axis.
ToolPart round_rod(double radius, double tip, double length) {
  ToolPart part;
  part.is_cutting = false;
  add_arc(part.profile, tip + radius, radius, 0, k_right_angle);
  part.profile.push_back({tip + length, radius});
  part.profile.push_back({tip + length, 0});
  return part;
}

/// Returns a ball around the origin, truncated at height `top`.
ToolPart ball_to(double radius, double top) {
  ToolPart part;
  part.is_fluted = true;
  add_arc(part.profile, 0, radius, 0, std::acos(std::clamp(-top / radius, -1.0, 1.0)));
  part.profile.push_back({part.profile.back().x, 0});
  return part;
}
/// Returns a tapered body between a ball around the origin and a smaller ball of radius `end`, which ends at
/// height `top`.
ToolPart between_balls(double radius, double end, double top) {
  ToolPart part;
  part.is_fluted = true;
  const double lean = k_right_angle + std::asin(std::clamp((radius - end) / (top - end), -1.0, 1.0));
  add_arc(part.profile, 0, radius, 0, lean);
  add_arc(part.profile, top - end, end, lean, 2 * k_right_angle);
  return part;
}

}  // namespace

double drawn_radius(const sim::Value& parameters) { return 0.5 * Fields(parameters).diameter; }

ToolAppearance ball_appearance(double radius) {
  ToolAppearance tool;
  tool.radius = radius;
  tool.shaft_radius = 0.45 * radius;
  tool.parts.push_back(ball_to(radius, radius));
  return tool;
}

ToolAppearance surface_appearance(std::shared_ptr<const haptics::MeshTree> mesh,
                                  std::span<const dvec2> profile) {
  ToolAppearance tool;
  tool.is_ball = tool.has_shaft = false;
  tool.mesh = std::move(mesh);
  if (tool.mesh) return tool;
  // The ends of the body are closed by disks.
  ToolPart& body = tool.parts.emplace_back();
  body.is_cutting = false;
  body.profile.emplace_back(profile.front().x, 0);
  body.profile.insert(body.profile.end(), profile.begin(), profile.end());
  body.profile.emplace_back(profile.back().x, 0);
  return tool;
}

std::optional<volume::TurnedSolid> solid_of(const ToolAppearance& tool) {
  if (tool.parts.empty()) return std::nullopt;
  constexpr double k_shaft = 110, k_neck = 0.05;  // mm: length of shaft and grip; length of the taper to it
  constexpr int k_facets = 24;
  const double radius = std::max(0.3, tool.radius), shaft = std::max(0.3, tool.shaft_radius),
               low = tool.is_ball ? -radius : 0, from = std::max(tool.shaft_from, low + 1.5 * radius);
  const std::vector<volume::TurnedRing> rings{{low + 0.15 * radius, 0.5 * radius},
                                              {low + 0.5 * radius, 0.87 * radius},
                                              {low + radius, radius},
                                              {from, radius},
                                              {from + k_neck, shaft},
                                              {from + k_shaft, shaft}};
  return volume::turned_solid(low, rings, from + k_shaft + k_neck, k_facets);
}

ToolAppearance appearance_of(const sim::Value& parameters) {
  const Fields f(parameters);
  ToolAppearance tool;
  const double radius = tool.radius = 0.5 * f.diameter;
  if (f.width > 0 && f.opening > 0 && f.jaw > 0) {
    const double half_width = tool.radius = 0.5 * f.width;
    tool.is_ball = false;
    tool.shaft_radius = std::max(0.6, 0.35 * half_width);
    if (f.kind == "kerrison") {
      tool.parts = {
          disc(-f.jaw, 0, half_width), disc(f.opening, f.opening + 2 * f.jaw, half_width),
          rod({-half_width, 0, -f.jaw}, {-half_width, 0, f.opening + 4 * f.jaw}, 0.45 * tool.shaft_radius)};
      tool.shaft_from = f.opening + 2 * f.jaw;
      tool.foot = {.kind = FootTool::Kind::kerrison,
                   .radius = half_width,
                   .thickness = f.jaw,
                   .opening = f.opening,
                   .jaw = f.jaw};
      return tool;
    }
    tool.shaft_from = half_width + 2 * f.opening;
    for (const double side : {-1.0, 1.0}) {
      ToolPart cup = disc(0, f.jaw, half_width);
      cup.at = {0.5 * side * f.opening, 0, -half_width};
      cup.along = {side, 0, 0};
      tool.parts.push_back(cup);
      tool.parts.push_back(rod({0.5 * side * (f.opening + f.jaw), 0, -0.5 * half_width},
                               {0, 0, tool.shaft_from}, 0.6 * tool.shaft_radius));
    }
    return tool;
  }
  if (radius <= 0) return tool;
  tool.shaft_radius = std::min(0.5 * radius, 1.2);
  if (f.inner > 0) {
    const double tip = 0.5 * f.inner, begin = f.lead - tip;
    tool.parts = {ball_to(tip, begin), disc(begin, begin + f.diameter, radius, false)};
    constexpr double k_thickest = 20;  // mm of bone
    tool.insertion = k_thickest;
    tool.is_drill = true;
    tool.shaft_from = begin + f.diameter;
    tool.shaft_radius = 0.4 * radius;
  } else if (f.foot > 0) {
    constexpr double k_foot_thickness = 0.8;
    tool.parts = {drum(radius, radius, f.length), disc(-k_foot_thickness, 0, 0.5 * f.foot, false)};
    tool.shaft_from = f.length;
    tool.shaft_radius = 1.6 * radius;
    tool.foot = {.kind = FootTool::Kind::craniotome,
                 .radius = 0.5 * f.foot,
                 .thickness = k_foot_thickness,
                 .bit = radius,
                 .length = f.length};
  } else if (f.shape == "cylinder" || f.shape == "barrel") {
    const bool is_barrel = f.shape == "barrel";
    tool.shaft_from = f.length > 0 ? f.length : (is_barrel ? 2.4 : 3) * radius;
    tool.parts = {drum(radius, is_barrel ? 0.75 * radius : radius, tool.shaft_from)};
  } else if (f.shape == "match-head") {
    tool.shaft_from = (f.length > 0 ? f.length : 3 * radius) - radius;
    tool.parts = {between_balls(radius, 0.6 * radius, tool.shaft_from)};
  } else if (f.shape.empty() && f.length > f.diameter) {
    // The origin of a probe is its tip; for a probe that is guided by walls, it is the centre of the round
    // end.
    const double tip = f.guide == "walls" ? -radius : 0;
    tool.parts = {round_rod(radius, tip, f.length)};
    tool.shaft_from = tip + f.length;
    tool.insertion = f.length;
    tool.shaft_radius = 1.6 * radius;
  } else {
    return ball_appearance(radius);
  }
  tool.is_ball = false;
  return tool;
}

bool step_first_number(sim::Value& parameters, int steps) {
  if (parameters.is_empty()) return false;
  for (const sim::Field& field : parameters.schema().fields) {
    const auto pointer = field.pointer_in(parameters.data());
    if (auto* const* number = std::get_if<double*>(&pointer)) {
      **number = std::clamp(**number + 0.5 * steps, std::max(0.5, field.info.low), field.info.high);
      return true;
    }
  }
  return false;
}

}  // namespace trephine::view
