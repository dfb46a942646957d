// Forbidden structures in OperationController: positions at which a mouse's tool rests on them.
#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "apps/view/operation_controller.h"
#include "apps/view/tool_appearance.h"

namespace trephine::view {

using glm::dvec3;

namespace {
constexpr double k_soft_clearance = 0.5;  // mm, of an idle tool; covers the motion between two frames
}  // namespace

/// Returns the distance (mm) from the tool's end to the nearest forbidden structure. `tip`: position of the
/// hand. `expected`: as in sim::Forbidden::clearance().
double OperationController::clearance_at(const dvec3& tip, double expected) const {
  const ToolAppearance tool = appearance_of(state_.tool);
  double radius = std::max(state_.tool_radius, tool.radius);
  // Centre of the tool's end: a ball is held at its centre, another tool at its lowest point, a Kerrison and
  // a craniotome at the upper face of the foot.
  dvec3 middle = tool.is_ball && state_.tool_radius > 0 ? dvec3(0) : (radius - tool.foot.jaw) * shaft();
  if (tool.foot.kind == FootTool::Kind::craniotome)
    radius = 0.5 * tool.foot.thickness, middle = -radius * shaft();
  double clearance = 1e9;
  for (const auto& structure : live_.engine().forbidden())
    clearance = std::min(clearance, structure->clearance({tip + middle, radius}, expected));
  return clearance;
}

/// Returns the largest distance (mm) along the ray, up to `along`, at which an idle tool keeps clear of all
/// forbidden structures. For rays on which the tool does not rest on bone.
double OperationController::distance_above_soft(const Ray& ray, double along) const {
  constexpr int k_max_steps = 20;
  for (int i = 0; i < k_max_steps; ++i) {
    const double clearance = clearance_at(ray.origin + along * ray.direction, 0);
    if (clearance >= k_soft_clearance) break;
    along -= std::max(0.1, k_soft_clearance - clearance);
  }
  return along;
}

/// Returns the distance (mm) along the ray at which a tool that moves along it meets a forbidden structure
/// before the bone at `hit` (negative: no bone), such as the dural sac between two vertebrae; nullopt if it
/// meets no structure. The search starts at the clip plane, unless the clip plane is ignored.
std::optional<double> OperationController::distance_to_forbidden(const Ray& ray, double hit,
                                                                 Viewport::Clipping clipping) const {
  constexpr double k_before = 2, k_step = 0.25;  // mm: least distance before the bone, shortest step
  // A pressed tool may go through a structure that the clip plane opens, to the bone behind it.
  const auto clip = clipping == Viewport::Clipping::applied ? viewport_.clip_plane() : std::nullopt;
  if (live_.engine().forbidden().empty() || (clip && is_pressed_)) return std::nullopt;
  double begin = 0;
  if (clip)
    if (const double across = glm::dot(ray.direction, clip->normal); std::abs(across) > 1e-9)
      begin = std::max(0.0, glm::dot(clip->at - ray.origin, clip->normal) / across);
  // Search only the part of the ray in the ball around the scan.
  const volume::Volume& base = *scene_->base;
  const dvec3 last(base.size - 1);
  const double middle = glm::dot(base.frame.world_from_volume(0.5 * last) - ray.origin, ray.direction),
               reach = 0.5 * glm::length(base.frame.vector_world_from_volume(last));
  const double end = hit < 0 ? middle + reach : hit - state_.tool_radius - k_before;
  double expected = sim::Forbidden::k_reach;
  for (double along = std::max(begin, middle - reach); along < end;) {
    expected = clearance_at(ray.origin + along * ray.direction, expected);
    if (expected < k_soft_clearance) return along;
    along += std::max(k_step, expected - k_soft_clearance);
  }
  return std::nullopt;
}

/// True if a tool that moves straight from one position to another would enter a forbidden structure, such as
/// the convex dural sac between two positions on it.
bool OperationController::passes_forbidden(const dvec3& from, const dvec3& to) const {
  constexpr double k_step = 0.5;  // mm
  const int count = static_cast<int>(std::ceil(glm::length(to - from) / k_step));
  for (int i = 1; i < count; ++i)
    if (clearance_at(glm::mix(from, to, static_cast<double>(i) / count), 0) <= 0) return true;
  return false;
}

/// Holds a tool in front of the whole anatomy if it would pass through clipped matter on its way. This is so
/// if the cursor is over a cut face, which cannot be worked on. For an idle tool, it is also so if there is a
/// structure between the clip plane and the bone at `hit`. Returns false if the tool is not held.
bool OperationController::wait_outside_clip(const Ray& ray, double hit) {
  if (!is_pressed_) is_face_refused_ = false;
  // A guided tool is independent of the cursor: a probe or a catheter stays in its track.
  if (!viewport_.clip_plane() || is_guided()) return false;
  const std::optional<double> face = viewport_.distance_to_clip_face(*version_, ray);
  if (!face && (is_pressed_ || hit < 0 || !distance_to_forbidden(ray, hit))) return false;
  constexpr double k_away = 5;  // mm
  double outer = viewport_.distance_to_solid(*version_, ray, Viewport::Clipping::ignored);
  if (face && outer < 0) outer = *face;  // the face shows soft tissue, and no bone is on the line of sight
  if (outer < 0 || (!face && outer >= hit)) return false;
  if (face && is_pressed_ && !std::exchange(is_face_refused_, true))
    show_refusal(
        "The cut face shows hidden matter, which cannot be reached. Press C until nothing is clipped.");
  double along = std::max(0.0, outer - state_.tool_radius - k_away);
  if (const std::optional<double> soft = distance_to_forbidden(ray, outer, Viewport::Clipping::ignored))
    along = std::min(along, *soft);
  const dvec3 request = ray.origin + along * ray.direction;
  is_over_bone_ = false;
  mouse_.set(request, turn_along(shaft()), false,
             glm::length(request - request_) > k_away ? std::optional(request) : std::nullopt);
  request_ = request;
  return true;
}

}  // namespace trephine::view
