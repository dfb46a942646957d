#include "sim/forbidden.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "volume/surface_nets.h"

namespace trephine::sim {

using glm::dvec3;

Forbidden::Forbidden(std::shared_ptr<const volume::Volume> volume, const volume::Shape& shape)
    : volume_(std::move(volume)), field_(*volume_, shape) {
  const dvec3& spacing = volume_->frame.spacing();
  step_mm_ = 0.5 * std::min({spacing.x, spacing.y, spacing.z});
}

volume::Result<std::shared_ptr<const Forbidden>> Forbidden::build(
    std::shared_ptr<const volume::Volume> volume, const volume::Shape& shape, int threads) {
  if (shape.is_label() && volume->labels.is_empty())
    return volume::Error{"a forbidden structure is a label of a volume without labels", shape.name, "", "",
                         ""};
  const auto bits = volume::Occupancy::build(*volume, shape, threads);
  if (bits.count_solid() == 0)
    return volume::Error{"a forbidden structure is empty", shape.name, "no voxel", "at least one", ""};
  std::shared_ptr<Forbidden> made(new Forbidden(std::move(volume), shape));
  const volume::Mesh net = volume::surface_net({&made->field_, nullptr, &bits, false}, threads);
  std::vector<dvec3> vertices;
  for (const glm::vec3& v : net.vertices.span())
    vertices.push_back(made->volume_->frame.world_from_volume(dvec3(v)));
  made->surface_ =
      haptics::MeshTree(std::move(vertices), {net.triangles.span().begin(), net.triangles.span().end()});
  return std::shared_ptr<const Forbidden>(std::move(made));
}

/// Of a point from the surface, at most `reach`.
double Forbidden::distance(const dvec3& p, double reach) const noexcept {
  double nearest = reach;
  surface_.for_near(p, reach,
                    [&](const haptics::MeshTree::Near& near) { nearest = std::min(nearest, near.distance); });
  return nearest;
}

double Forbidden::clearance(const ToolBall& ball, double expected) const noexcept {
  const dvec3 v = volume_->frame.volume_from_world(ball.centre);
  const bool is_within = field_.value(v) >= 0;
  // Around the middle, farther and farther out; so much farther as the ball is large.
  const double most = k_reach + ball.radius;
  double reach = std::clamp(std::abs(expected + ball.radius) + step_mm_, 2 * step_mm_, most);
  double away = distance(ball.centre, reach);
  while (away >= reach && reach < most) {
    reach = std::min(most, 2 * reach);
    away = distance(ball.centre, reach);
  }
  return (is_within ? -away : away) - ball.radius;
}

double Forbidden::clearance(const dvec3& from, const ToolBall& ball, double expected) const noexcept {
  const double length = glm::length(ball.centre - from);
  // From far away nothing is met on a short way.
  double least = clearance(ball, expected);
  if (least > length) return least;
  constexpr double k_most_parts = 4096;  // faster than any hand: a metre in a tick
  const int parts = static_cast<int>(std::min(std::ceil(length / step_mm_), k_most_parts));
  for (int i = 1; i < parts; ++i) {
    const dvec3 at = from + (static_cast<double>(i) / parts) * (ball.centre - from);
    least = std::min(least, clearance({at, ball.radius}, least));
  }
  return least;
}

const Schema& ForbiddenEntered::schema() {
  static constexpr Field fields[] = {field<&ForbiddenEntered::structure>("structure"),
                                     field<&ForbiddenEntered::is_working>("working")};
  static constexpr Schema table{"forbidden-entered", 1, fields};
  return table;
}

const Schema& ForbiddenLeft::schema() {
  static constexpr Field fields[] = {field<&ForbiddenLeft::structure>("structure"),
                                     field<&ForbiddenLeft::deepest>("deepest", {.unit = "mm"}),
                                     field<&ForbiddenLeft::seconds>("seconds", {.unit = "s"})};
  static constexpr Schema table{"forbidden-left", 1, fields};
  return table;
}

const Schema& StructureStripped::schema() {
  static constexpr Field fields[] = {field<&StructureStripped::structure>("structure"),
                                     field<&StructureStripped::deepest>("deepest", {.unit = "mm"})};
  static constexpr Schema table{"structure-stripped", 1, fields};
  return table;
}
const Schema& StructureTouched::schema() {
  static constexpr Field fields[] = {field<&StructureTouched::structure>("structure"),
                                     field<&StructureTouched::deepest>("deepest", {.unit = "mm"})};
  static constexpr Schema table{"structure-touched", 1, fields};
  return table;
}
const Schema& StructureTorn::schema() {
  static constexpr Field fields[] = {field<&StructureTorn::structure>("structure"),
                                     field<&StructureTorn::deepest>("deepest", {.unit = "mm"})};
  static constexpr Schema table{"structure-torn", 1, fields};
  return table;
}

const Schema& ForbiddenWatch::schema() {
  static constexpr Field fields[] = {field<&ForbiddenWatch::is_inside>("inside"),
                                     field<&ForbiddenWatch::clearance>("clearance", {.unit = "mm"}),
                                     field<&ForbiddenWatch::nearest>("nearest", {.unit = "mm"}),
                                     field<&ForbiddenWatch::deepest_now>("deepest_now", {.unit = "mm"}),
                                     field<&ForbiddenWatch::has_worked>("has_worked"),
                                     field<&ForbiddenWatch::is_torn>("is_torn"),
                                     field<&ForbiddenWatch::entries>("entries"),
                                     field<&ForbiddenWatch::ticks_inside>("ticks_inside"),
                                     field<&ForbiddenWatch::entered_tick>("entered_tick")};
  static constexpr Schema table{"forbidden-watch", 1, fields};
  return table;
}

}  // namespace trephine::sim
