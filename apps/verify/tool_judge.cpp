#include "apps/verify/tool_judge.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>

namespace trephine::verify {

using glm::dvec2, glm::dvec3;

/// Adds positions on a circle about the axis. `inward`: normal in the half plane of the axis, as (along,
/// outward).
void ToolJudge::add_circle(double along, double radius, const dvec2& inward, double spacing) {
  const int count = std::max(1, static_cast<int>(std::ceil(2 * std::numbers::pi * radius / spacing)));
  for (int i = 0; i < count; ++i) {
    const double angle = 2 * std::numbers::pi * i / count;
    const dvec2 out(std::cos(angle), std::sin(angle));
    positions_.push_back({dvec3(radius * out, along), dvec3(inward.y * out, inward.x)});
  }
}

void ToolJudge::add_revolution(std::span<const dvec2> rings, double spacing) {
  profile_.assign(rings.begin(), rings.end());
  for (std::size_t i = 0; i + 1 < rings.size(); ++i) {
    const dvec2 step = rings[i + 1] - rings[i];
    const double length = glm::length(step);
    if (length == 0) continue;
    // The outward normal of a cone is perpendicular to its line, away from the axis.
    const dvec2 inward = dvec2(step.y, -step.x) / length;
    const int count = std::max(1, static_cast<int>(std::ceil(length / spacing)));
    for (int k = 0; k <= count; ++k) {
      const dvec2 at = rings[i] + static_cast<double>(k) / count * step;
      add_circle(at.x, at.y, inward, spacing);
    }
  }
  if (rings.empty()) return;
  const auto add_disk = [&](const dvec2& ring, double inward) {
    const int count = static_cast<int>(std::ceil(ring.y / spacing));
    for (int k = 0; k < count; ++k) add_circle(ring.x, ring.y * k / count, {inward, 0}, spacing);
  };
  const double forward = rings.back().x > rings.front().x ? 1 : -1;
  add_disk(rings.front(), forward);
  add_disk(rings.back(), -forward);
}

void ToolJudge::add_mesh(std::span<const dvec3> vertices, std::span<const std::uint32_t> triangles,
                         double spacing) {
  for (std::size_t t = 0; t + 2 < triangles.size(); t += 3) {
    const dvec3 &a = vertices[triangles[t]], &b = vertices[triangles[t + 1]], &c = vertices[triangles[t + 2]];
    const dvec3 normal = glm::cross(b - a, c - a);
    const double area = glm::length(normal);
    if (area == 0) continue;
    triangles_.push_back({a, b, c});
    const double longest = std::max({glm::length(b - a), glm::length(c - a), glm::length(c - b)});
    const int count = std::max(1, static_cast<int>(std::ceil(longest / spacing)));
    for (int i = 0; i <= count; ++i)
      for (int k = 0; i + k <= count; ++k)
        positions_.push_back(
            {a + static_cast<double>(i) / count * (b - a) + static_cast<double>(k) / count * (c - a),
             -normal / area});
  }
}

void ToolJudge::add_ball(const dvec3& centre, double radius, double spacing) {
  balls_.push_back({centre, radius});
  const int rows = std::max(2, static_cast<int>(std::ceil(std::numbers::pi * radius / spacing)));
  for (int row = 0; row <= rows; ++row) {
    const double angle = std::numbers::pi * row / rows, flat = std::sin(angle), along = std::cos(angle);
    const int count =
        std::max(1, static_cast<int>(std::ceil(2 * std::numbers::pi * radius * flat / spacing)));
    for (int i = 0; i < count; ++i) {
      const double turn = 2 * std::numbers::pi * i / count;
      const dvec3 out(flat * std::cos(turn), flat * std::sin(turn), along);
      positions_.push_back({centre + radius * out, -out});
    }
  }
}

double ToolJudge::penetration_mm(const dvec3& position_world, const glm::dmat3& axes,
                                 const IsSolid& is_solid) const {
  constexpr double k_step = 0.01, k_most = 5;  // mm
  double deepest = 0;
  for (const Position& position : positions_) {
    // Goes straight into the tool while this surface is the nearest one.
    for (double d = 0; d < k_most; d += k_step) {
      const dvec3 at = position.at + d * position.inward;
      if (!is_solid(position_world + axes * at)) break;
      const double depth = depth_in_tool(at);
      if (depth < d - 2 * k_step) break;
      deepest = std::max(deepest, depth);
    }
  }
  return deepest;
}

/// Returns the distance from a position to the nearest triangle, mm.
double ToolJudge::distance_to_triangles(const dvec3& at) const {
  double nearest = 1e300;
  const auto add_edge = [&](const dvec3& from, const dvec3& to) {
    const dvec3 side = to - from;
    const double share = std::clamp(glm::dot(at - from, side) / glm::dot(side, side), 0.0, 1.0);
    nearest = std::min(nearest, glm::length(at - from - share * side));
  };
  for (const auto& [a, b, c] : triangles_) {
    const dvec3 normal = glm::normalize(glm::cross(b - a, c - a));
    const dvec3 foot = at - glm::dot(at - a, normal) * normal;
    const bool is_inside = glm::dot(glm::cross(b - a, foot - a), normal) >= 0 &&
                           glm::dot(glm::cross(c - b, foot - b), normal) >= 0 &&
                           glm::dot(glm::cross(a - c, foot - c), normal) >= 0;
    if (is_inside)
      nearest = std::min(nearest, std::abs(glm::dot(at - a, normal)));
    else
      add_edge(a, b), add_edge(b, c), add_edge(c, a);
  }
  return nearest;
}

/// Returns the distance from a position in the tool to the surface of the tool, mm; 0 outside.
double ToolJudge::depth_in_tool(const dvec3& at) const {
  double depth = 0;
  for (const Ball& ball : balls_) depth = std::max(depth, ball.radius - glm::length(at - ball.centre));
  if (!triangles_.empty()) return std::max(depth, distance_to_triangles(at));
  if (profile_.size() < 2) return depth;
  const dvec2 p(at.z, std::sqrt(at.x * at.x + at.y * at.y));
  double nearest = 1e300;
  const auto add_side = [&](const dvec2& a, const dvec2& b) {
    const dvec2 side = b - a;
    const double square = glm::dot(side, side);
    const double t = square > 0 ? std::clamp(glm::dot(p - a, side) / square, 0.0, 1.0) : 0;
    nearest = std::min(nearest, glm::length(p - a - t * side));
  };
  for (std::size_t i = 0; i + 1 < profile_.size(); ++i) add_side(profile_[i], profile_[i + 1]);
  add_side({profile_.front().x, 0}, profile_.front());
  add_side({profile_.back().x, 0}, profile_.back());
  return std::max(depth, nearest);
}

}  // namespace trephine::verify
