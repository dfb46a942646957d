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

void ForbiddenWatch::follow(const dvec3& from, const ToolBall& ball, const Nearness& now,
                            double slack) noexcept {
  if (!(now.clearance < 0)) {
    has_entry = is_beyond_middle = false;
    depth = 0;
    return;
  }
  depth = -now.clearance;
  if (!now.has_surface) {  // far inside
    is_beyond_middle = has_entry;
    if (has_entry) depth = std::max(depth, glm::length(ball.centre - entry_world) + ball.radius);
    return;
  }
  if (!now.is_centre_inside || !has_entry) {
    entry_world = now.surface_world;
    is_beyond_middle = false;
    has_entry = true;
    return;
  }
  // The nearest point of the surface goes along with the ball, until the middle of the structure is passed:
  // then it leaps to another side, and the entry stays where it was.
  const double leap = glm::length(now.surface_world - entry_world);
  const bool is_other_side = glm::dot(entry_world - ball.centre, now.surface_world - ball.centre) < 0 ||
                             leap > 2 * glm::length(ball.centre - from) + slack;
  is_beyond_middle = is_beyond_middle ? leap > slack : is_other_side;
  if (is_beyond_middle)
    depth = std::max(depth, glm::length(ball.centre - entry_world) + ball.radius);
  else
    entry_world = now.surface_world;
}

/// Returns the distance from the surface, at most `reach`, and its nearest point.
double Forbidden::distance(const dvec3& p, double reach, dvec3& nearest_world) const noexcept {
  double nearest = reach;
  surface_.for_near(p, reach, [&](const haptics::MeshTree::Near& near) {
    if (near.distance < nearest) nearest = near.distance, nearest_world = near.nearest;
  });
  return nearest;
}

Nearness Forbidden::locate(const ToolBall& ball, double expected) const noexcept {
  const dvec3 v = volume_->frame.volume_from_world(ball.centre);
  Nearness found;
  found.is_centre_inside = field_.value(v) >= 0;
  // Around the middle, farther and farther out; so much farther as the ball is large.
  const double most = k_reach + ball.radius;
  double reach = std::clamp(std::abs(expected + ball.radius) + step_mm_, 2 * step_mm_, most);
  double away = distance(ball.centre, reach, found.surface_world);
  while (away >= reach && reach < most) {
    reach = std::min(most, 2 * reach);
    away = distance(ball.centre, reach, found.surface_world);
  }
  found.has_surface = away < reach;
  found.clearance = (found.is_centre_inside ? -away : away) - ball.radius;
  return found;
}

/// Calls each(place) for places half a voxel apart between `from` and `to`, without the ends.
template <class Each>
void Forbidden::for_places(const dvec3& from, const dvec3& to, const Each& each) const noexcept {
  constexpr double k_most_parts = 4096;  // faster than any hand: a metre in a tick
  const int parts = static_cast<int>(std::min(std::ceil(glm::length(to - from) / step_mm_), k_most_parts));
  for (int i = 1; i < parts; ++i) each(from + (static_cast<double>(i) / parts) * (to - from));
}

double Forbidden::clearance(const dvec3& from, const ToolBall& ball, double expected) const noexcept {
  // From far away nothing is met on a short way.
  double least = clearance(ball, expected);
  if (least > glm::length(ball.centre - from)) return least;
  for_places(from, ball.centre, [&](const dvec3& at) {
    least = std::min(least, clearance({at, ball.radius}, least));
  });
  return least;
}

double Forbidden::follow(const dvec3& from, const ToolBall& ball, double expected,
                         ForbiddenWatch& watch) const noexcept {
  const double slack = 4 * step_mm_;
  const Nearness end = locate(ball, expected);
  double least = end.clearance;
  if (least <= glm::length(ball.centre - from)) {
    dvec3 before = from;
    double deepest = 0;
    for_places(from, ball.centre, [&](const dvec3& at) {
      const ToolBall there{at, ball.radius};
      const Nearness now = locate(there, least);
      watch.follow(before, there, now, slack);
      least = std::min(least, now.clearance);
      deepest = std::max(deepest, watch.depth);
      before = at;
    });
    watch.follow(before, ball, end, slack);
    // A structure that the ball passed within one tick was entered, too.
    if (least < 0) watch.depth = std::max(watch.depth, deepest);
  } else {
    watch.follow(from, ball, end, slack);
  }
  return least;
}

double Forbidden::set_down(const ToolBall& ball, double expected, ForbiddenWatch& watch) const noexcept {
  watch.has_entry = false;
  const Nearness now = locate(ball, expected);
  watch.follow(ball.centre, ball, now, 4 * step_mm_);
  return now.clearance;
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
                                     field<&ForbiddenWatch::entered_tick>("entered_tick"),
                                     field<&ForbiddenWatch::has_entry>("has_entry"),
                                     field<&ForbiddenWatch::is_beyond_middle>("is_beyond_middle"),
                                     field<&ForbiddenWatch::entry_world>("entry", {.unit = "mm"}),
                                     field<&ForbiddenWatch::depth>("depth", {.unit = "mm"})};
  static constexpr Schema table{"forbidden-watch", 1, fields};
  return table;
}

}  // namespace trephine::sim
