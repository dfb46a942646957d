#include "sim/api/forbidden.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "volume/base/deterministic_math.h"
#include "volume/surface/surface_facts.h"
#include "volume/surface/surface_nets.h"

namespace trephine::sim {

using glm::dvec3;

namespace {

bool is_dura(const std::string& name) {
  std::string small = name;
  for (char& c : small) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  return small == "dura" || small == "dura mater" || small == "dura_mater";
}

}  // namespace

Forbidden::Forbidden(std::shared_ptr<const volume::Volume> volume, const volume::Shape& shape)
    : name_(shape.name), is_membrane_(is_dura(name_)), volume_(std::move(volume)), field_(*volume_, shape) {
  const dvec3& spacing = volume_->frame.spacing();
  step_mm_ = 0.5 * std::min({spacing.x, spacing.y, spacing.z});
}

Result<std::shared_ptr<const Forbidden>> Forbidden::build(std::shared_ptr<const volume::Volume> volume,
                                                          const volume::Shape& shape, int threads) {
  if (shape.is_label() && volume->labels.is_empty())
    return Error{.what = "the volume of a forbidden structure has no labels",
                 .where = shape.name,
                 .expected = "a scan with labels",
                 .remedy = "load the labels, or remove this forbidden structure"};
  const auto bits = volume::Occupancy::build(*volume, shape, threads);
  if (bits.count_solid() == 0)
    return Error{.what = "a forbidden structure is empty",
                 .where = shape.name,
                 .found = "no voxel",
                 .expected = "at least one",
                 .remedy = "choose another label, or remove this forbidden structure"};
  std::shared_ptr<Forbidden> result(new Forbidden(std::move(volume), shape));
  const volume::Mesh net = volume::surface_net({&result->field_, nullptr, &bits, false}, threads);
  std::vector<dvec3> vertices;
  for (const glm::vec3& v : net.vertices.span())
    vertices.push_back(result->volume_->frame.world_from_volume(dvec3(v)));
  result->surface_ =
      haptics::MeshTree(std::move(vertices), {net.triangles.span().begin(), net.triangles.span().end()});
  return std::shared_ptr<const Forbidden>(std::move(result));
}

Forbidden::Forbidden(std::string name, haptics::MeshTree surface)
    : name_(std::move(name)), is_membrane_(is_dura(name_)), surface_(std::move(surface)) {
  constexpr double k_step = 0.25;  // mm
  step_mm_ = k_step;
}

Result<std::shared_ptr<const Forbidden>> Forbidden::build(const std::string& name,
                                                          const haptics::MeshTree& model,
                                                          const haptics::Placement& placement) {
  const volume::SurfaceFacts facts = volume::facts_of(model.vertices(), model.triangles());
  if (!facts.is_solid())
    return Error{.what = "a forbidden model is not the surface of a solid",
                 .where = name,
                 .found = facts.open_edges > 0          ? std::to_string(facts.open_edges) + " open edges"
                          : facts.misoriented_edges > 0 ? "triangles of opposite orientations"
                                                        : "a surface that faces inward",
                 .expected = "triangles of a closed surface, counter-clockwise as viewed from outside",
                 .remedy = "close its holes and correct its normals in the program that made it"};
  std::vector<dvec3> vertices;
  vertices.reserve(model.vertices().size());
  for (const dvec3& v : model.vertices()) vertices.push_back(placement.world_from_local(v));
  return std::shared_ptr<const Forbidden>(
      new Forbidden(name, haptics::MeshTree(std::move(vertices), model.triangles())));
}

/// Returns true if p is inside a closed model. Requires that p is at most `reach` mm from its surface. Uses
/// the normals of all triangles nearest to p, weighted by their angles at the nearest point (Baerentzen and
/// Aanaes 2005).
bool Forbidden::is_inside(const dvec3& p, double reach) const noexcept {
  constexpr double k_same = 1e-9;  // mm, and share of the distance
  double nearest = reach;
  surface_.for_near(p, reach,
                    [&](const haptics::MeshTree::Near& near) { nearest = std::min(nearest, near.distance); });
  dvec3 normal(0), offset(0);
  surface_.for_near(p, nearest * (1 + k_same) + k_same, [&](const haptics::MeshTree::Near& near) {
    const auto corners = surface_.corners(near.triangle);
    // Angle of the triangle at the nearest point: the corner's angle at a corner, pi on an edge, 2 pi inside.
    double angle = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      const dvec3 a = corners[k] - near.nearest, b = corners[(k + 1) % 3] - near.nearest;
      const double lengths = glm::length(a) * glm::length(b);
      if (lengths > 0) angle += deterministic_acos(std::clamp(glm::dot(a, b) / lengths, -1.0, 1.0));
    }
    for (std::size_t k = 0; k < 3; ++k)
      if (glm::length(corners[k] - near.nearest) <= k_same) {
        const dvec3 a = glm::normalize(corners[(k + 1) % 3] - corners[k]),
                    b = glm::normalize(corners[(k + 2) % 3] - corners[k]);
        angle = deterministic_acos(std::clamp(glm::dot(a, b), -1.0, 1.0));
      }
    normal += angle * near.normal;
    offset = p - near.nearest;
  });
  return glm::dot(offset, normal) < 0;
}

bool ForbiddenWatch::is_far(const ToolBall& ball) noexcept {
  const double bound = measured - glm::length(ball.centre - measured_at);
  if (!(bound > std::max(nearest, Forbidden::k_always_measured))) return false;
  clearance = bound;
  return true;
}

void ForbiddenWatch::follow(const dvec3& from, const ToolBall& ball, const Nearness& nearness, double slack,
                            bool is_membrane) noexcept {
  // Behind a membrane, the nearest point of the membrane is toward the outside.
  const bool is_behind = is_membrane && has_entry && nearness.has_surface && !nearness.is_centre_inside &&
                         glm::dot(ball.centre - entry_world, entry_outward) < 0;
  if (is_behind && (nearness.clearance < 0 || !is_torn)) {
    const dvec3 out = nearness.surface_world - ball.centre;
    if (glm::length(out) > 0) entry_outward = glm::normalize(out);
    entry_world = nearness.surface_world;
    depth = glm::length(out) + ball.radius;
    return;
  }
  if (!(nearness.clearance < 0)) {
    has_entry = is_beyond_middle = false;
    depth = 0;
    return;
  }
  depth = -nearness.clearance;
  if (!nearness.has_surface) {  // the surface is out of reach: the ball is far inside
    is_beyond_middle = has_entry;
    if (has_entry) depth = std::max(depth, glm::length(ball.centre - entry_world) + ball.radius);
    return;
  }
  if (!nearness.is_centre_inside || !has_entry) {
    entry_world = nearness.surface_world;
    const dvec3 out = nearness.is_centre_inside ? from - entry_world : ball.centre - entry_world;
    if (glm::length(out) > 0) entry_outward = glm::normalize(out);
    is_beyond_middle = false;
    has_entry = true;
    return;
  }
  // The nearest point of the surface moves with the ball until the ball passes the middle of the structure.
  // Then the nearest point jumps to another side, and `entry_world` is kept.
  const double jump = glm::length(nearness.surface_world - entry_world);
  const bool is_other_side = glm::dot(entry_world - ball.centre, nearness.surface_world - ball.centre) < 0 ||
                             jump > 2 * glm::length(ball.centre - from) + slack;
  is_beyond_middle = is_beyond_middle ? jump > slack : is_other_side;
  if (is_beyond_middle)
    depth = std::max(depth, glm::length(ball.centre - entry_world) + ball.radius);
  else
    entry_world = nearness.surface_world;
}

/// Returns the distance to the surface, mm, at most `reach`. Sets the nearest point of the surface if the
/// distance is less than `reach`.
double Forbidden::distance(const dvec3& p, double reach, dvec3& nearest_world) const noexcept {
  double nearest = reach;
  surface_.for_nearest(p, reach, 0, [&](const haptics::MeshTree::Near& near) {
    if (near.distance < nearest) nearest = near.distance, nearest_world = near.nearest;
  });
  return nearest;
}

bool Forbidden::contains(const dvec3& p) const noexcept {
  if (volume_) return field_.value(volume_->frame.volume_from_world(p)) >= 0;
  return p == glm::clamp(p, surface_.low(), surface_.high()) && locate({p, 0}, 0).is_centre_inside;
}

Nearness Forbidden::locate(const ToolBall& ball, double expected) const noexcept {
  Nearness result;
  if (volume_) result.is_centre_inside = field_.value(volume_->frame.volume_from_world(ball.centre)) >= 0;
  // The search around the ball's centre starts with the expected distance. Its reach is doubled until it
  // contains a part of the surface, at most to k_reach plus the ball's radius.
  const double farthest = k_reach + ball.radius;
  double reach = std::clamp(std::abs(expected + ball.radius) + step_mm_, 2 * step_mm_, farthest);
  double surface_mm = distance(ball.centre, reach, result.surface_world);
  while (surface_mm >= reach && reach < farthest) {
    reach = std::min(farthest, 2 * reach);
    surface_mm = distance(ball.centre, reach, result.surface_world);
  }
  result.has_surface = surface_mm < reach;
  if (!volume_) {
    // A point that is farther than `reach` from the surface may be deep inside.
    const dvec3 low = surface_.low(), high = surface_.high();
    const bool is_in_box = ball.centre == glm::clamp(ball.centre, low, high);
    if (result.has_surface || is_in_box)
      result.is_centre_inside =
          is_inside(ball.centre, result.has_surface ? surface_mm + step_mm_ : glm::length(high - low));
  }
  result.clearance = (result.is_centre_inside ? -surface_mm : surface_mm) - ball.radius;
  return result;
}

/// Calls each(position) for positions between `from` and `to` without the ends. They are at most step_mm_
/// apart, except on a path of more than 4096 steps.
template <class Each>
void Forbidden::for_positions(const dvec3& from, const dvec3& to, const Each& each) const noexcept {
  constexpr double k_max_parts = 4096;  // a metre at 0.25 mm; no hand moves so far in a tick
  const int parts = static_cast<int>(std::min(std::ceil(glm::length(to - from) / step_mm_), k_max_parts));
  for (int i = 1; i < parts; ++i) each(from + (static_cast<double>(i) / parts) * (to - from));
}

double Forbidden::clearance(const dvec3& from, const ToolBall& ball, double expected) const noexcept {
  // A path that is shorter than the clearance at its end cannot reach the structure.
  double least = clearance(ball, expected);
  if (least > glm::length(ball.centre - from)) return least;
  for_positions(from, ball.centre, [&](const dvec3& at) {
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
    dvec3 previous = from;
    double deepest = 0;
    for_positions(from, ball.centre, [&](const dvec3& at) {
      const ToolBall sample{at, ball.radius};
      const Nearness nearness = locate(sample, least);
      watch.follow(previous, sample, nearness, slack, is_membrane_);
      least = std::min(least, nearness.clearance);
      deepest = std::max(deepest, watch.depth);
      previous = at;
    });
    watch.follow(previous, ball, end, slack, is_membrane_);
    // A structure that the ball crossed within one tick was entered as well.
    if (least < 0) watch.depth = std::max(watch.depth, deepest);
  } else {
    watch.follow(from, ball, end, slack, is_membrane_);
  }
  return least;
}

double Forbidden::begin_path(const ToolBall& ball, double expected, ForbiddenWatch& watch) const noexcept {
  watch.has_entry = false;
  const Nearness nearness = locate(ball, expected);
  watch.follow(ball.centre, ball, nearness, 4 * step_mm_, is_membrane_);
  return nearness.clearance;
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
  static constexpr Field fields[] = {
      field<&ForbiddenWatch::is_inside>("inside"),
      field<&ForbiddenWatch::clearance>("clearance", {.unit = "mm"}),
      field<&ForbiddenWatch::nearest>("nearest", {.unit = "mm"}),
      field<&ForbiddenWatch::measured>("measured", {.unit = "mm"}),
      field<&ForbiddenWatch::measured_at>("measured_at", {.unit = "mm"}),
      field<&ForbiddenWatch::deepest_now>("deepest_now", {.unit = "mm"}),
      field<&ForbiddenWatch::deepest_world>("deepest_at", {.unit = "mm"}),
      field<&ForbiddenWatch::has_worked>("has_worked"),
      field<&ForbiddenWatch::is_working>("is_working"),
      field<&ForbiddenWatch::deepest_working>("deepest_working", {.unit = "mm"}),
      field<&ForbiddenWatch::is_torn>("is_torn"),
      field<&ForbiddenWatch::entries>("entries"),
      field<&ForbiddenWatch::ticks_inside>("ticks_inside"),
      field<&ForbiddenWatch::entered_tick>("entered_tick"),
      field<&ForbiddenWatch::has_entry>("has_entry"),
      field<&ForbiddenWatch::is_beyond_middle>("is_beyond_middle"),
      field<&ForbiddenWatch::entry_world>("entry", {.unit = "mm"}),
      field<&ForbiddenWatch::entry_outward>("entry_outward"),
      field<&ForbiddenWatch::depth>("depth", {.unit = "mm"})};
  static constexpr Schema table{"forbidden-watch", 1, fields};
  return table;
}

}  // namespace trephine::sim
