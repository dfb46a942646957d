#include "apps/view/foot_place.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>

namespace trephine::view {

using glm::dvec3;

namespace {

constexpr double k_pi = 3.14159265358979;
constexpr double k_above = 3, k_below = 25;  // mm: how far a surface may rise and bone may reach
constexpr double k_gap = 0.3;                // mm between foot and bone
constexpr double k_step = 0.25;              // mm
constexpr double k_hollow = 3;               // mm: marrow spaces that a window of intensities leaves open

/// Two directions across a shaft.
std::array<dvec3, 2> across(const dvec3& shaft) {
  const dvec3 other = std::abs(shaft.x) < 0.6 ? dvec3(1, 0, 0) : dvec3(0, 1, 0);
  const dvec3 a = glm::normalize(glm::cross(shaft, other));
  return {a, glm::cross(shaft, a)};
}

/// Bone along a line that leads down the shaft. Heights are mm along the shaft from where the line begins.
struct Column {
  bool has_bone = false;
  double top = 0, bottom = 0;  ///< of the first stretch of bone, hollows included
};
Column column_at(const BoneTest& is_bone, const dvec3& at, const dvec3& shaft) {
  Column c;
  // Between a height in bone and one outside, within a sixteenth of a step.
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

/// Is a disc across the shaft free of bone between two heights?
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

/// mm along `way` at which a walk over the surface leaves the bone; nothing within `farthest`.
std::optional<double> edge_along(const BoneTest& is_bone, const dvec3& at, const dvec3& shaft,
                                 const dvec3& way, double from, double farthest) {
  constexpr double k_stride = 0.5;
  const auto has_bone = [&](double s) { return column_at(is_bone, at + s * way, shaft).has_bone; };
  bool was_over_bone = has_bone(from);
  for (double s = from + k_stride; s <= farthest; s += k_stride) {
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

/// Fits the foot under one edge, which lies `s` mm along `way` from `at`.
Fit fit_under(const BoneTest& is_bone, const FootTool& tool, const dvec3& at, const dvec3& shaft,
              const dvec3& way, double s, double reach, FootPlace& place) {
  // The bone that the foot reaches under.
  double top = -1e9, bottom = 1e9;
  const dvec3 aside = glm::cross(shaft, way);
  for (double inward = k_step; inward <= std::max(0.5, reach + tool.radius); inward += 2 * k_step)
    for (const double off : {-0.7, 0.0, 0.7}) {
      const Column c = column_at(is_bone, at + (s - inward) * way + off * tool.radius * aside, shaft);
      if (c.has_bone) top = std::max(top, c.top), bottom = std::min(bottom, c.bottom);
    }
  if (top < bottom) return Fit::no_room;
  place.bone_thickness = top - bottom;
  if (place.bone_thickness + k_gap > tool.opening) return Fit::too_thick;
  const double height = bottom - k_gap;  // of the top of the foot
  const double begin = s + tool.radius + k_gap, end = s - reach;
  const auto over = [&](double along, double h) { return at + along * way + h * shaft; };
  // Down next to the edge, then under it.
  if (!is_disc_free(is_bone, over(begin, 0), shaft, tool.radius, height - tool.thickness - 0.1, k_above))
    return Fit::no_room;
  for (double along = begin; along > end - 1e-9; along -= 0.5)
    if (!is_disc_free(is_bone, over(along, 0), shaft, tool.radius, height - tool.thickness, height - 0.1))
      return Fit::no_room;
  if (!is_disc_free(is_bone, over(end, 0), shaft, tool.radius, height - tool.thickness, height - 0.1) ||
      !is_disc_free(is_bone, over(end, 0), shaft, tool.radius, height + tool.opening + 0.1,
                    height + tool.opening + tool.jaw))
    return Fit::no_room;
  place.at_world = over(end, height);
  place.edge_world = over(s, top);
  place.way = {over(begin, std::max(top, 0.0) + 4), over(begin, height)};
  place.turn = glm::normalize(glm::quat_cast(glm::dmat3(way, glm::cross(shaft, way), shaft)));
  return Fit::fits;
}

/// The edge on either side of a place of it, on the surface.
std::vector<dvec3> line_along(const BoneTest& is_bone, const dvec3& at, const dvec3& shaft, const dvec3& way,
                              double s) {
  constexpr double k_half = 4, k_far = 3;  // mm
  const dvec3 aside = glm::cross(shaft, way);
  std::vector<dvec3> line;
  for (double off = -k_half; off <= k_half; off += 0.5) {
    const dvec3 from = at + off * aside;
    const std::optional<double> here = edge_along(is_bone, from, shaft, way, s - k_far, s + k_far);
    if (!here) continue;
    const Column c = column_at(is_bone, from + (*here - 0.3) * way, shaft);
    if (c.has_bone) line.push_back(from + *here * way + (c.top + 0.3) * shaft);
  }
  return line;
}

}  // namespace

FootSearch find_edge(const BoneTest& is_bone, const FootTool& tool, const dvec3& at_world, const dvec3& shaft,
                     double reach, const dvec3& open) {
  constexpr int k_ways = 16;
  constexpr double k_farthest = 8;  // mm
  const auto [a, b] = across(shaft);
  struct Edge {
    double s;
    dvec3 way;
  };
  std::vector<Edge> edges;
  for (int i = 0; i < k_ways; ++i) {
    const double angle = 2 * k_pi * i / k_ways;
    const dvec3 way = std::cos(angle) * a + std::sin(angle) * b;
    if (open != dvec3(0) && glm::dot(way, open) < 0.5) continue;
    if (const auto s = edge_along(is_bone, at_world, shaft, way, 0, k_farthest)) edges.push_back({*s, way});
  }
  if (edges.empty()) return {std::nullopt, "no edge of bone is near. Move the tool to an edge."};
  std::sort(edges.begin(), edges.end(), [](const Edge& x, const Edge& y) { return x.s < y.s; });
  constexpr std::size_t k_most_edges = 6;
  edges.resize(std::min(edges.size(), k_most_edges));
  bool is_too_thick = false;
  for (Edge& edge : edges) {
    // Square to the edge, by its course on both sides.
    for (int i = 0; i < 2; ++i) {
      constexpr double k_off = 1.2, k_far = 2;  // mm
      const dvec3 aside = glm::cross(shaft, edge.way), middle = at_world + edge.s * edge.way;
      const auto left = edge_along(is_bone, middle - k_off * aside, shaft, edge.way, -k_far, k_far),
                 right = edge_along(is_bone, middle + k_off * aside, shaft, edge.way, -k_far, k_far);
      if (!left || !right) break;
      const dvec3 way = glm::normalize(2 * k_off * edge.way - (*right - *left) * aside);
      const auto s = edge_along(is_bone, at_world, shaft, way, 0, k_farthest);
      if (!s) break;
      edge = {*s, way};
    }
    // There is often room a little farther along the edge.
    for (const double off : {0.0, 1.0, -1.0, 2.0, -2.0, 3.0, -3.0}) {
      const dvec3 from = at_world + off * glm::cross(shaft, edge.way);
      const auto s = off == 0
                         ? std::optional<double>(edge.s)
                         : edge_along(is_bone, from, shaft, edge.way, std::max(0.0, edge.s - 3), edge.s + 3);
      if (!s) continue;
      FootPlace place;
      const Fit fit = fit_under(is_bone, tool, from, shaft, edge.way, *s, reach, place);
      is_too_thick = is_too_thick || fit == Fit::too_thick;
      if (fit == Fit::too_thick) break;  // as it is next to it
      if (fit != Fit::fits) continue;
      place.edge = line_along(is_bone, from, shaft, edge.way, *s);
      return {std::move(place), {}};
    }
  }
  return {std::nullopt, is_too_thick
                            ? "the bone is thicker than the jaws open. Thin it with a burr first."
                            : "the foot has no room at this edge. Try another place, or tilt the tool."};
}

std::optional<double> foot_depth(const BoneTest& is_bone, const FootTool& tool, const dvec3& at_world,
                                 const dvec3& shaft) {
  constexpr int k_around = 8;
  const auto [a, b] = across(shaft);
  // A neighbouring place may lie above or below the plane, by what a surface bends over a foot.
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
    const dvec3 off = tool.radius * (std::cos(angle) * a + std::sin(angle) * b);
    if (const std::optional<double> beside = depth_at(at_world + off)) deepest = std::max(*deepest, *beside);
  }
  if (deepest) *deepest += k_gap;
  return deepest;
}

FootSearch find_hole(const BoneTest& is_bone, const BoneTest& was_bone, const FootTool& tool,
                     const dvec3& at_world, const dvec3& shaft) {
  constexpr double k_farthest = 8, k_grid = 1, k_toe = 0.6;  // mm, mm, of the radius
  const auto [a, b] = across(shaft);
  std::vector<glm::dvec2> offsets;
  const int steps = static_cast<int>(k_farthest / k_grid);
  for (int i = -steps; i <= steps; ++i)
    for (int j = -steps; j <= steps; ++j)
      if (i * i + j * j <= steps * steps) offsets.emplace_back(k_grid * i, k_grid * j);
  std::sort(offsets.begin(), offsets.end(),
            [](const glm::dvec2& x, const glm::dvec2& y) { return glm::dot(x, x) < glm::dot(y, y); });
  constexpr int k_most = 40;  // places that are looked at closely
  bool is_open = false;
  int looked = 0;
  for (const glm::dvec2& off : offsets) {
    const dvec3 at = at_world + off.x * a + off.y * b;
    if (is_bone(at - 0.5 * shaft) || column_at(is_bone, at, shaft).has_bone) continue;
    is_open = true;
    if (!is_disc_free(is_bone, at, shaft, tool.bit, -2, k_above)) continue;
    if (++looked > k_most) break;
    const std::optional<double> depth = foot_depth(was_bone, tool, at, shaft);
    if (!depth) continue;
    const double height = -*depth;
    // The foot of a craniotome is a toe that is put in aslant: the hole is as wide as most of its radius.
    if (!is_disc_free(is_bone, at, shaft, std::max(tool.bit, k_toe * tool.radius), height, k_above) ||
        !is_disc_free(is_bone, at, shaft, tool.radius, height - tool.thickness, height))
      continue;
    FootPlace place;
    place.at_world = at + height * shaft;
    place.way = {at + 4.0 * shaft};
    place.turn = glm::dquat(dvec3(0, 0, 1), shaft);
    place.bone_thickness = *depth;
    return {std::move(place), {}};
  }
  return {std::nullopt, is_open ? "the foot has no room under the bone. Widen the hole to its inner side."
                                : "no burr hole is near. Make one with the perforator first."};
}

}  // namespace trephine::view
