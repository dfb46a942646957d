#include "volume/scan/surgical_plan.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <set>

namespace trephine::volume {

namespace {

constexpr std::size_t k_longest_name = 200;
constexpr double k_farthest = 1e6;  // mm

bool is_name(const std::string& name) {
  return !name.empty() && name.size() <= k_longest_name &&
         std::all_of(name.begin(), name.end(), [](char c) { return static_cast<unsigned char>(c) >= 32; });
}

bool is_position(const glm::dvec3& p) {
  return std::abs(p.x) <= k_farthest && std::abs(p.y) <= k_farthest && std::abs(p.z) <= k_farthest;
}

/// Checks number and names of the objects of one kind.
template <class T>
Status check_names(const std::vector<T>& objects, const char* kind) {
  if (objects.size() > k_max_planned)
    return Error{.what = "the plan has too many objects of one kind",
                 .where = kind,
                 .found = std::to_string(objects.size()),
                 .expected = "at most " + std::to_string(k_max_planned),
                 .remedy = "remove objects of this kind"};
  std::set<std::string> names;
  for (const T& object : objects) {
    if (!is_name(object.name))
      return Error{.what = "an object of the plan has an invalid name",
                   .where = kind,
                   .found = object.name.substr(0, 40),
                   .expected = "1 to 200 characters in one line",
                   .remedy = "rename the object"};
    if (!names.insert(object.name).second)
      return Error{.what = "two objects of the plan have the same name",
                   .where = kind,
                   .found = object.name,
                   .expected = "a different name for each object",
                   .remedy = "rename one of them"};
  }
  return std::nullopt;
}

Error invalid(const char* kind, const std::string& name, std::string expected) {
  return {.what = "an object of the plan is invalid",
          .where = kind,
          .found = name,
          .expected = std::move(expected),
          .remedy = "correct the object, or remove it from the plan"};
}

/// Returns true if three of the points are not on one line.
bool encloses_area(const std::vector<glm::dvec3>& points) {
  constexpr double k_least = 1e-6;  // mm2
  const auto farthest = std::max_element(points.begin(), points.end(), [&](const auto& a, const auto& b) {
    return glm::length(a - points[0]) < glm::length(b - points[0]);
  });
  return std::any_of(points.begin(), points.end(), [&](const glm::dvec3& p) {
    return glm::length(glm::cross(p - points[0], *farthest - points[0])) > k_least;
  });
}

Status check_score(const std::vector<ScoreLimit>& score) {
  if (score.size() > k_max_planned)
    return invalid("score", std::to_string(score.size()) + " limits",
                   "at most " + std::to_string(k_max_planned) + " limits");
  for (const ScoreLimit& limit : score)
    if (!is_name(limit.finding) || !(std::abs(limit.full_at) <= k_farthest) ||
        !(std::abs(limit.zero_at) <= k_farthest) || limit.full_at == limit.zero_at ||
        !(limit.weight >= 0 && limit.weight <= k_farthest))
      return invalid("score", limit.finding, "a finding, two different limits and a weight of 0 or more");
  return std::nullopt;
}

}  // namespace

std::vector<ScoreLimit> score_limits(const SurgicalPlan& plan) {
  std::vector<ScoreLimit> limits = plan.score;
  for (const ScoreLimit& limit : plan.procedure.score)
    if (std::none_of(plan.score.begin(), plan.score.end(),
                     [&](const ScoreLimit& own) { return own.finding == limit.finding; }))
      limits.push_back(limit);
  return limits;
}

Status check(const SurgicalPlan& plan) {
  if (Status error = check_names(plan.trajectories, "trajectories")) return error;
  if (Status error = check_names(plan.landmarks, "landmarks")) return error;
  if (Status error = check_names(plan.outlines, "outlines")) return error;
  if (Status error = check_names(plan.planes, "planes")) return error;
  if (Status error = check_names(plan.targets, "targets")) return error;
  for (const PlannedTrajectory& t : plan.trajectories) {
    if (!is_position(t.entry_world) || !is_position(t.target_world) || t.entry_world == t.target_world)
      return invalid("trajectories", t.name,
                     "an entry and another point as target, with coordinates of at most 1000000 mm");
    if (!(t.diameter >= 0 && t.diameter <= 100))
      return invalid("trajectories", t.name, "a diameter of 0 to 100 mm");
    if (!t.side.empty() && t.side != "left" && t.side != "right")
      return invalid("trajectories", t.name, "side left or right, or no side");
    if ((!t.group.empty() && !is_name(t.group)) || (!t.vertebra.empty() && !is_name(t.vertebra)))
      return invalid("trajectories", t.name,
                     "a group and a vertebra of at most 200 characters, each in one line");
  }
  for (const PlannedLandmark& l : plan.landmarks)
    if (!is_position(l.position_world))
      return invalid("landmarks", l.name, "a position with coordinates of at most 1000000 mm");
  for (const PlannedOutline& o : plan.outlines) {
    if (o.points_world.size() < 3 || o.points_world.size() > k_max_planned ||
        !std::all_of(o.points_world.begin(), o.points_world.end(), is_position))
      return invalid(
          "outlines", o.name,
          "3 to " + std::to_string(k_max_planned) + " points, with coordinates of at most 1000000 mm");
    if (!encloses_area(o.points_world)) return invalid("outlines", o.name, "points that are not on one line");
  }
  for (const PlannedPlane& p : plan.planes)
    if (!is_position(p.point_world) || !(std::abs(glm::length(p.normal_world) - 1) < 1e-9))
      return invalid("planes", p.name, "a point with coordinates of at most 1000000 mm, and a unit normal");
  for (const PlannedTarget& t : plan.targets)
    if (!is_name(t.label)) return invalid("targets", t.name, "the name of a label");
  for (const std::vector<ScoreLimit>* score : {&plan.score, &plan.procedure.score})
    if (Status error = check_score(*score)) return error;
  return check(plan.procedure);
}

}  // namespace trephine::volume
