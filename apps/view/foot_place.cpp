#include "apps/view/foot_place.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>

#include "volume/base/axes.h"

namespace trephine::view {

using glm::dvec3;

namespace {

constexpr double k_pi = 3.14159265358979;
constexpr double k_above = 3, k_below = 25;  // mm searched above and below a point of the surface
constexpr double k_gap = 0.3;                // mm between foot and bone
constexpr double k_step = 0.25;              // mm between samples along a shaft
constexpr double k_hollow = 3;               // mm; largest hollow (marrow space) that counts as bone

/// Returns two unit vectors perpendicular to a shaft.
std::array<dvec3, 2> across(const dvec3& shaft) {
  const dvec3 axis = volume::non_parallel_axis(shaft);
  const dvec3 a = glm::normalize(glm::cross(shaft, axis));
  return {a, glm::cross(shaft, a)};
}

/// Bone along a line parallel to the shaft. Heights are mm along the shaft from the given point.
struct Column {
  bool has_bone = false;
  double top = 0, bottom = 0;  ///< extent of the uppermost bone, including hollows
};
Column column_at(const BoneTest& is_bone, const dvec3& at, const dvec3& shaft) {
  Column c;
  // Bisects between a height in bone and one outside, to a sixteenth of a step.
  const auto border = [&](double in, double out) {
    for (int i = 0; i < 4; ++i) (is_bone(at + 0.5 * (in + out) * shaft) ? in : out) = 0.5 * (in + out);
    return 0.5 * (in + out);
  };
  for (double h = k_above; h >= -k_below; h -= k_step) {
    const bool is_in = is_bone(at + h * shaft);
    if (is_in && !c.has_bone) c.has_bone = true, c.top = border(h, h + k_step);
    if (is_in) c.bottom = h;
    if (c.has_bone && c.bottom - h > k_hollow) break;
  }
  if (c.has_bone) c.bottom = border(c.bottom, c.bottom - k_step);
  return c;
}

/// True if a disc perpendicular to the shaft is free of bone at all heights between `low` and `high`.
bool is_disc_free(const BoneTest& is_bone, const dvec3& at, const dvec3& shaft, double radius, double low,
                  double high) {
  constexpr int k_around = 12;
  const auto [a, b] = across(shaft);
  const int layers = std::max(1, static_cast<int>(std::ceil((high - low) / (2 * k_step))));
  for (int i = 0; i <= layers; ++i) {
    const dvec3 middle = at + (low + (high - low) * i / layers) * shaft;
    if (is_bone(middle)) return false;
    for (const double share : {0.5, 1.0})
      for (int k = 0; k < k_around; ++k) {
        const double angle = 2 * k_pi * k / k_around;
        if (is_bone(middle + share * radius * (std::cos(angle) * a + std::sin(angle) * b))) return false;
      }
  }
  return true;
}

/// Returns the distance (mm) along `direction`, between `from` and `farthest`, at which the bone ends.
/// Returns nullopt if the bone does not end in this interval, or if a wall of bone, such as a spinous
/// process, rises before its end.
std::optional<double> edge_along(const BoneTest& is_bone, const dvec3& at, const dvec3& shaft,
                                 const dvec3& direction, double from, double farthest) {
  constexpr double k_stride = 0.5;
  const auto has_bone = [&](double s) { return column_at(is_bone, at + s * direction, shaft).has_bone; };
  bool was_over_bone = has_bone(from);
  for (double s = from + k_stride; s <= farthest; s += k_stride) {
    if (is_bone(at + s * direction + k_above * shaft)) return std::nullopt;
    const bool is_over_bone = has_bone(s);
    if (was_over_bone && !is_over_bone) {
      double low = s - k_stride, high = s;
      for (int i = 0; i < 3; ++i) (has_bone(0.5 * (low + high)) ? low : high) = 0.5 * (low + high);
      return 0.5 * (low + high);
    }
    was_over_bone = is_over_bone;
  }
  return std::nullopt;
}

enum class Fit { fits, too_thick, no_room };

/// Fits the foot under an edge at `s` mm along `direction` from `at`. `reach`: as in find_edge(). Sets `pose`
/// if the foot fits.
Fit fit_under(const BoneTest& is_bone, const FootTool& tool, const dvec3& at, const dvec3& shaft,
              const dvec3& direction, double s, double reach, FootPose& pose) {
  // Extent of the bone above the foot.
  double top = -1e9, bottom = 1e9;
  const dvec3 tangent = glm::cross(shaft, direction);
  for (double inward = k_step; inward <= std::max(0.5, reach + tool.radius); inward += 2 * k_step)
    for (const double offset : {-0.7, 0.0, 0.7}) {
      const Column c =
          column_at(is_bone, at + (s - inward) * direction + offset * tool.radius * tangent, shaft);
      if (c.has_bone) top = std::max(top, c.top), bottom = std::min(bottom, c.bottom);
    }
  if (top < bottom) return Fit::no_room;
  pose.bone_thickness = top - bottom;
  if (pose.bone_thickness + k_gap > tool.opening) return Fit::too_thick;
  const double height = bottom - k_gap;  // height of the foot's upper face
  const double begin = s + tool.radius + k_gap, end = s - reach;
  const auto point_at = [&](double along, double h) { return at + along * direction + h * shaft; };
  // The foot moves down next to the edge, then under the bone: both parts of the path must be free.
  if (!is_disc_free(is_bone, point_at(begin, 0), shaft, tool.radius, height - tool.thickness - 0.1, k_above))
    return Fit::no_room;
  for (double along = begin; along > end - 1e-9; along -= 0.5)
    if (!is_disc_free(is_bone, point_at(along, 0), shaft, tool.radius, height - tool.thickness, height - 0.1))
      return Fit::no_room;
  if (!is_disc_free(is_bone, point_at(end, 0), shaft, tool.radius, height - tool.thickness, height - 0.1) ||
      !is_disc_free(is_bone, point_at(end, 0), shaft, tool.radius, height + tool.opening + 0.1,
                    height + tool.opening + tool.jaw))
    return Fit::no_room;
  pose.at_world = point_at(end, height);
  pose.edge_world = point_at(s, top);
  pose.path = {point_at(begin, std::max(top, 0.0) + 4), point_at(begin, height)};
  pose.turn = glm::normalize(glm::quat_cast(glm::dmat3(direction, glm::cross(shaft, direction), shaft)));
  return Fit::fits;
}

/// Returns a line along the edge, on the surface, to 4 mm on either side.
std::vector<dvec3> line_along(const BoneTest& is_bone, const dvec3& at, const dvec3& shaft,
                              const dvec3& direction, double s) {
  constexpr double k_half = 4, k_far = 3;  // mm
  const dvec3 tangent = glm::cross(shaft, direction);
  std::vector<dvec3> line;
  for (double offset = -k_half; offset <= k_half; offset += 0.5) {
    const dvec3 from = at + offset * tangent;
    const std::optional<double> edge = edge_along(is_bone, from, shaft, direction, s - k_far, s + k_far);
    if (!edge) continue;
    const Column c = column_at(is_bone, from + (*edge - 0.3) * direction, shaft);
    if (c.has_bone) line.push_back(from + *edge * direction + (c.top + 0.3) * shaft);
  }
  return line;
}

}  // namespace

FootSearch find_edge(const BoneTest& is_bone, const FootTool& tool, const dvec3& at_world, const dvec3& shaft,
                     double reach, const dvec3& open) {
  constexpr int k_directions = 16;
  constexpr double k_farthest = 8;  // mm
  const auto [a, b] = across(shaft);
  struct Edge {
    double s;
    dvec3 direction;
  };
  std::vector<Edge> edges;
  for (int i = 0; i < k_directions; ++i) {
    const double angle = 2 * k_pi * i / k_directions;
    const dvec3 direction = std::cos(angle) * a + std::sin(angle) * b;
    if (open != dvec3(0) && glm::dot(direction, open) < 0.5) continue;
    if (const auto s = edge_along(is_bone, at_world, shaft, direction, 0, k_farthest))
      edges.push_back({*s, direction});
  }
  if (edges.empty()) return {std::nullopt, "no edge of bone is near. Move the tool to an edge."};
  std::sort(edges.begin(), edges.end(), [](const Edge& x, const Edge& y) { return x.s < y.s; });
  constexpr std::size_t k_max_edges = 6;
  edges.resize(std::min(edges.size(), k_max_edges));
  bool is_too_thick = false;
  for (Edge& edge : edges) {
    // Make the direction perpendicular to the edge, which is located again 1.2 mm to both sides.
    for (int i = 0; i < 2; ++i) {
      constexpr double k_offset = 1.2, k_far = 2;  // mm
      const dvec3 tangent = glm::cross(shaft, edge.direction), middle = at_world + edge.s * edge.direction;
      const auto left =
                     edge_along(is_bone, middle - k_offset * tangent, shaft, edge.direction, -k_far, k_far),
                 right =
                     edge_along(is_bone, middle + k_offset * tangent, shaft, edge.direction, -k_far, k_far);
      if (!left || !right) break;
      const dvec3 direction = glm::normalize(2 * k_offset * edge.direction - (*right - *left) * tangent);
      const auto s = edge_along(is_bone, at_world, shaft, direction, 0, k_farthest);
      if (!s) break;
      edge = {*s, direction};
    }
    // There is often room a little farther along the edge.
    for (const double offset : {0.0, 1.0, -1.0, 2.0, -2.0, 3.0, -3.0}) {
      const dvec3 from = at_world + offset * glm::cross(shaft, edge.direction);
      const auto s = offset == 0 ? std::optional<double>(edge.s)
                                 : edge_along(is_bone, from, shaft, edge.direction, std::max(0.0, edge.s - 3),
                                              edge.s + 3);
      if (!s) continue;
      FootPose pose;
      const Fit fit = fit_under(is_bone, tool, from, shaft, edge.direction, *s, reach, pose);
      is_too_thick = is_too_thick || fit == Fit::too_thick;
      if (fit == Fit::too_thick) break;  // also too thick farther along the edge
      if (fit != Fit::fits) continue;
      pose.edge = line_along(is_bone, from, shaft, edge.direction, *s);
      return {std::move(pose), {}};
    }
  }
  return {std::nullopt, is_too_thick
                            ? "the bone is thicker than the jaws open. Thin it with a burr first."
                            : "the foot has no room at this edge. Return to a burr hole, or tilt the tool."};
}

std::optional<double> foot_depth(const BoneTest& is_bone, const FootTool& tool, const dvec3& at_world,
                                 const dvec3& shaft) {
  constexpr int k_around = 8;
  const auto [a, b] = across(shaft);
  // On a curved surface, neighbouring points may be higher than `at_world`: the search starts 1 mm above it.
  const auto depth_at = [&](const dvec3& at) -> std::optional<double> {
    double last = -k_above;
    bool has_bone = false;
    for (double depth = -1; depth <= k_below; depth += 0.5 * k_step) {
      if (is_bone(at - depth * shaft))
        last = depth, has_bone = true;
      else if (has_bone && depth - last > k_hollow)
        return last + 0.25 * k_step;
    }
    return std::nullopt;
  };
  std::optional<double> deepest = depth_at(at_world);
  for (int k = 0; k < k_around && deepest; ++k) {
    const double angle = 2 * k_pi * k / k_around;
    const dvec3 offset = tool.radius * (std::cos(angle) * a + std::sin(angle) * b);
    if (const std::optional<double> depth = depth_at(at_world + offset)) deepest = std::max(*deepest, *depth);
  }
  if (deepest) *deepest += k_gap;
  return deepest;
}

namespace {
/// Finds a pose along `shaft`, within `farthest` mm of `at_world`. `is_open`: becomes true if the hole goes
/// through the bone.
FootSearch find_upright(const BoneTest& is_bone, const BoneTest& was_bone, const FootTool& tool,
                        const dvec3& at_world, const dvec3& shaft, double farthest, bool& is_open) {
  constexpr double k_grid = 1, k_toe = 0.6;  // mm; share of the radius
  const auto [a, b] = across(shaft);
  std::vector<glm::dvec2> offsets;
  const int steps = static_cast<int>(farthest / k_grid);
  for (int i = -steps; i <= steps; ++i)
    for (int j = -steps; j <= steps; ++j)
      if (i * i + j * j <= steps * steps) offsets.emplace_back(k_grid * i, k_grid * j);
  std::sort(offsets.begin(), offsets.end(),
            [](const glm::dvec2& x, const glm::dvec2& y) { return glm::dot(x, x) < glm::dot(y, y); });
  constexpr int k_max = 40;  // points at which the foot is fitted
  bool is_drilled = false;
  int fitted = 0;
  for (const glm::dvec2& offset : offsets) {
    const dvec3 at = at_world + offset.x * a + offset.y * b;
    if (is_bone(at - 0.5 * shaft)) continue;
    is_drilled |= was_bone(at - 0.5 * shaft);
    if (column_at(is_bone, at, shaft).has_bone) continue;
    is_open = true;
    if (!is_disc_free(is_bone, at, shaft, tool.bit, -2, k_above)) continue;
    if (++fitted > k_max) break;
    const std::optional<double> depth = foot_depth(was_bone, tool, at, shaft);
    if (!depth) continue;
    const double height = -*depth;
    // The foot of a craniotome is a toe that is inserted obliquely: the hole need not be as wide as the foot.
    if (!is_disc_free(is_bone, at, shaft, std::max(tool.bit, k_toe * tool.radius), height, k_above) ||
        !is_disc_free(is_bone, at, shaft, tool.radius, height - tool.thickness, height))
      continue;
    FootPose pose;
    pose.at_world = at + height * shaft;
    pose.path = {at + 4.0 * shaft};
    pose.turn = glm::dquat(dvec3(0, 0, 1), shaft);
    pose.bone_thickness = *depth;
    return {std::move(pose), {}};
  }
  return {
      std::nullopt,
      is_open
          ? "the foot has no room under the bone. Widen the inner side of the hole with a burr, to about " +
                std::to_string(static_cast<int>(std::ceil(2 * tool.radius))) + " mm."
      : is_drilled ? "the hole is too narrow at its inner end. Widen that end with a burr."
                   : "no burr hole is near. Make one with the perforator first."};
}
}  // namespace

FootSearch find_hole(const BoneTest& is_bone, const BoneTest& was_bone, const FootTool& tool,
                     const dvec3& at_world, const dvec3& shaft) {
  constexpr double k_farthest = 8, k_near = 3;  // mm
  bool is_open = false;
  FootSearch upright = find_upright(is_bone, was_bone, tool, at_world, shaft, k_farthest, is_open);
  if (upright.pose || !is_open) return upright;
  const auto [a, b] = across(shaft);
  constexpr int k_directions = 8;
  for (const double degrees : {8.0, 16.0, 24.0})
    for (int i = 0; i < k_directions; ++i) {
      const double tilt = degrees * k_pi / 180, around = 2 * k_pi * i / k_directions;
      const dvec3 tilted =
          std::cos(tilt) * shaft + std::sin(tilt) * (std::cos(around) * a + std::sin(around) * b);
      FootSearch oblique = find_upright(is_bone, was_bone, tool, at_world, tilted, k_near, is_open);
      if (oblique.pose) return oblique;
    }
  return upright;
}

}  // namespace trephine::view
