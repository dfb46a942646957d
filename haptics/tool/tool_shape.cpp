#include "haptics/tool/tool_shape.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <string>

#include "haptics/mesh/mesh_tree.h"
#include "haptics/tool/point_shell.h"
#include "volume/base/mix_hash.h"
#include "volume/base/text.h"

namespace trephine::haptics {

ToolShape::ToolShape(double radius) {
  if (radius == 0) return;
  kind_ = Kind::ball;
  radius_ = extent_ = radius;
}

ToolShape::ToolShape(std::vector<Ball> balls) : kind_(Kind::balls), balls_(std::move(balls)) {
  double sum = 0;
  for (const Ball& ball : balls_) {
    const double length = glm::length(ball.centre);
    radius_ = std::max(radius_, ball.radius);
    arm_ = std::max(arm_, length);
    extent_ = std::max(extent_, ball.radius + length);
    has_equal_radii_ = has_equal_radii_ && ball.radius == balls_[0].radius;
    sum += glm::dot(ball.centre, ball.centre);
  }
  gyration_square_ =
      std::max(k_least_gyration_square, sum / static_cast<double>(std::max<std::size_t>(1, balls_.size())));
}

ToolShape::ToolShape(SharedShell shell) : kind_(Kind::shell), shell_(std::move(shell)) {
  double sum = 0;
  for (const PointShell::Point& point : shell_->points()) sum += glm::dot(point.position, point.position);
  shell_hash_ = shell_->hash();
  arm_ = extent_ = shell_->arm();
  gyration_square_ = std::max(k_least_gyration_square, sum / static_cast<double>(shell_->points().size()));
}

ToolShape::ToolShape(ToolProfile profile, SharedShell shell) : ToolShape(std::move(shell)) {
  profile_ = std::move(profile);
}

ToolShape::ToolShape(std::shared_ptr<const MeshTree> mesh, SharedShell shell) : ToolShape(std::move(shell)) {
  mesh_ = std::move(mesh);
}

ToolShape::ToolShape(ToolProfile profile) : kind_(Kind::shell), profile_(std::move(profile)) {
  for (const ToolProfile::Ring& ring : profile_.rings)
    arm_ = extent_ = std::max(arm_, std::sqrt(ring.along * ring.along + ring.radius * ring.radius));
}

std::vector<glm::dvec3> ToolShape::centres() const {
  std::vector<glm::dvec3> all;
  for (const Ball& ball : balls_) all.push_back(ball.centre);
  return all;
}

std::uint64_t ToolShape::fingerprint() const noexcept {
  MixHash hash;
  hash.add(std::uint64_t{static_cast<std::uint8_t>(kind_)});
  hash.add(radius_);
  for (const Ball& ball : balls_) {
    for (int a = 0; a < 3; ++a) hash.add(ball.centre[a]);
    hash.add(ball.radius);
  }
  for (const ToolProfile::Ring& ring : profile_.rings) hash.add(ring.along), hash.add(ring.radius);
  if (!profile_.rings.empty())
    hash.add(profile_.spacing);
  else if (shell_)
    hash.add(shell_hash_);
  return hash.value();
}

Status check(const ToolShape& tool) {
  if (!tool.profile().rings.empty()) return PointShell::check(tool.profile());
  for (const ToolShape::Ball& ball : tool.balls())
    if (!(ball.radius > 0))
      return Error{.what = "a tool of several balls needs a radius",
                   .where = "tool radius",
                   .found = rounded_text(ball.radius) + " mm",
                   .expected = "more than 0"};
  if (tool.balls().size() > ToolShape::k_max_balls)
    return Error{.what = "a tool has too many balls",
                 .where = "balls",
                 .found = std::to_string(tool.balls().size()),
                 .expected = "at most " + std::to_string(ToolShape::k_max_balls)};
  constexpr double k_longest = 300;  // mm
  for (const ToolShape::Ball& ball : tool.balls())
    if (const double length = glm::length(ball.centre); !(length <= k_longest))
      return Error{.what = "a ball of the tool is too far from the haptic interface point",
                   .where = "balls",
                   .found = rounded_text(length) + " mm",
                   .expected = "at most " + rounded_text(k_longest) + " mm"};
  return std::nullopt;
}

Result<SharedTool> sample_surface(const SharedTool& tool) {
  if (tool->kind() != ToolShape::Kind::shell || tool->shell()) return tool;
  Result<SharedShell> shell = PointShell::of_profile(tool->profile());
  if (!shell) return shell.error();
  return std::make_shared<const ToolShape>(tool->profile(), std::move(shell).value());
}

Result<SharedTool> make_tool(std::shared_ptr<const MeshTree> mesh, double spacing) {
  Result<SharedShell> shell = PointShell::of_mesh(mesh->vertices(), mesh->triangles(), spacing);
  if (!shell) return shell.error();
  return std::make_shared<const ToolShape>(std::move(mesh), std::move(shell).value());
}

Result<SharedTool> make_tool(std::vector<ToolShape::Ball> balls) {
  if (balls.empty()) return std::make_shared<const ToolShape>();
  auto tool = std::make_shared<const ToolShape>(std::move(balls));
  if (Status error = check(*tool)) return *error;
  return tool;
}

Result<SharedTool> make_tool(double radius, std::span<const glm::dvec3> centres) {
  if (centres.empty()) return std::make_shared<const ToolShape>(radius);
  std::vector<ToolShape::Ball> balls;
  for (const glm::dvec3& centre : centres) balls.push_back({centre, radius});
  return make_tool(std::move(balls));
}

}  // namespace trephine::haptics
