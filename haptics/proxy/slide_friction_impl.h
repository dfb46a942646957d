// Friction of a slide: finds the walls that stop the tool at a point, and moves the proxy back to the
// position at which their friction cone holds the pull. Included by slide.cpp only.
#pragma once

#include <utility>

#include "haptics/proxy/slide_impl.h"

namespace trephine::haptics {
namespace {

/// Adds the flanks of a groove that is sharper than the samples can represent. Such a groove is one smooth
/// wall with a narrow bottom. The flanks hold the tool, and their normals are read two samples to either
/// side. Returns false if the wall is no such groove, or if its flanks have walls of their own.
template <class Walls>
bool Slide<Walls>::add_flanks(const glm::dvec3& p_world, const Plane& plane, double coefficient,
                              HoldingWalls& holding) noexcept {
  if constexpr (requires { walls_.is_mesh(0); })
    if (walls_.is_mesh(plane.wall.shape)) return false;
  // Finds the direction along the wall in which the wall bends most toward the tool.
  glm::dvec3 u, w;
  tangents(plane.normal, u, w);
  const glm::dvec3 u_voxel = frame_.vector_volume_from_world(u), w_voxel = frame_.vector_volume_from_world(w);
  const glm::dvec3 hessian_u = plane.jet.hessian_times(u_voxel), hessian_w = plane.jet.hessian_times(w_voxel);
  const double uu = glm::dot(hessian_u, u_voxel), uw = glm::dot(hessian_u, w_voxel),
               ww = glm::dot(hessian_w, w_voxel);
  const double half = 0.5 * (uu - ww), root = std::sqrt(half * half + uw * uw),
               bend = (0.5 * (uu + ww) + root) / plane.steepness;
  constexpr double k_sharp = 0.5;  // curvature times a sample: a radius of two samples
  const double sample_mm = walls_.sample_mm(plane.wall);
  if (!(bend * sample_mm > k_sharp)) return false;
  if (walls_.is_near_crease(plane.wall.shape, frame_.volume_from_world(p_world))) return false;
  const glm::dvec3 across = half >= 0 ? (half + root) * u + uw * w : uw * u + (root - half) * w;
  const double size = glm::length(across);
  if (!(size > 0)) return false;
  constexpr double k_aside = 2;  // samples: farther than the smooth reconstruction rounds a kink
  const double flank_offset = walls_.longest_leg(plane.wall, k_aside * sample_mm);
  std::array<glm::dvec3, 2> normals;
  for (const int side : {0, 1}) {
    const glm::dvec3 at = p_world + (side == 0 ? -flank_offset : flank_offset) / size * across;
    const volume::ValueAndGradient flank =
        walls_.value_and_gradient(plane.wall, frame_.volume_from_world(at));
    const glm::dvec3 gradient = frame_.gradient_world_from_volume(flank.gradient);
    const double steepness = glm::length(gradient);
    if (!(steepness > 0) || !(flank.value > 0)) return false;
    normals[static_cast<std::size_t>(side)] = gradient / steepness;
  }
  for (const glm::dvec3& normal : normals) holding.add(normal, coefficient);
  return true;
}

/// Splits the pull of the hand among the walls that the tool touches. `planes`: the walls at `p_world`.
template <class Walls>
FrictionLoad Slide<Walls>::load_at(const glm::dvec3& p_world, const Planes& planes, bool is_static) noexcept {
  HoldingWalls holding;
  for (int k = 0; k < planes.count; ++k) {
    const Plane& plane = planes[k];
    if (plane.is_frozen || plane.distance > k_touch * voxel_mm_) continue;
    const Material& material = material_of(scene_, plane.wall.shape, side_of(plane.wall.is_back));
    const double coefficient = is_static ? material.static_friction : material.dynamic_friction;
    if (!add_flanks(p_world, plane, coefficient, holding)) holding.add(plane.normal, coefficient);
  }
  return friction_load(holding, hip_world_ - p_world);
}

/// Finds the point on the same walls near from_world + share * slide, and updates `planes` to it. `to`:
/// input, the first guess; output, the point found. Returns false if there is no such point.
template <class Walls>
bool Slide<Walls>::slide_by(const glm::dvec3& from_world, const glm::dvec3& slide, double share,
                            glm::dvec3& to, Planes& planes) noexcept {
  glm::dvec3 at = frame_.world_from_volume(to), p = from_world + share * slide - at;
  for (int i = 0; i < k_max_newton; ++i) {
    at += p;
    to = frame_.volume_from_world(at);
    if (!update_planes(planes, to, p)) return false;
    p = step_to_walls(planes);
    if (!(glm::dot(p, p) <= max_square_to_walls())) return false;
    if (glm::dot(p, p) < k_settled * k_settled * voxel_mm_ * voxel_mm_) break;
  }
  to = frame_.volume_from_world(at + p);
  return true;
}

/// Moves `to` and its planes back toward `from`, to the point at which the cone of the walls' dynamic
/// friction just holds the pull. Leaves `to` and its planes unchanged if no such point is found.
template <class Walls>
void Slide<Walls>::move_back(const glm::dvec3& from, glm::dvec3& to, Planes& planes) noexcept {
  const glm::dvec3 begin = frame_.world_from_volume(from), end = frame_.world_from_volume(to),
                   slide = end - begin;
  const FrictionLoad at_end = load_at(end, planes, false);
  const double length = glm::length(slide);
  if (!at_end.is_held() || at_end.limit <= 0 || !(length > 0)) return;
  constexpr double k_within = 4e-3;  // share of the limit: tolerance inside the cone
  constexpr int k_max_tries = 8;
  double low = 0, high = 1, low_excess = 1e300, high_excess = at_end.along - at_end.limit;
  Planes held, frictionless;
  held.copy_from(planes);
  frictionless.copy_from(planes);
  const glm::dvec3 frictionless_at = to;
  glm::dvec3 held_at = to, probe = to;
  double share = 1 - (1 - 0.25 * k_within) * at_end.limit / length;
  for (int i = 0; i < k_max_tries; ++i) {
    if (!(share > low && share < high)) share = 0.5 * (low + high);
    if (!slide_by(begin, slide, share, probe, planes)) break;
    const FrictionLoad load = load_at(frame_.world_from_volume(probe), planes, false);
    const double excess = load.along - load.limit;
    if (excess <= 0) {
      high = share, high_excess = excess, held_at = probe;
      held.copy_from(planes);
      if (excess >= -k_within * load.limit) break;
    } else {
      low = share, low_excess = excess;
    }
    // Uses the regula falsi, aimed a little into the cone, or bisection while the excess at `low` is unknown.
    const double aim = -0.25 * k_within * load.limit;
    share = low_excess < 1e299 ? low + (high - low) * (low_excess - aim) / (low_excess - high_excess)
                               : 0.5 * (low + high);
  }
  to = held_at;
  planes.copy_from(held);
  // Friction must not increase the distance to the HIP. A path that first leads farther from the HIP is
  // therefore not shortened to its beginning.
  if (energy(to) > energy(from)) {
    to = frictionless_at;
    planes.copy_from(frictionless);
  }
}

/// Applies Coulomb friction to a slide of one stage (cone of Salisbury and Tarr 1997, at the normals of the
/// proxy's own walls, each with its own share). Returns true if friction holds the proxy at `from`, whose
/// walls are `first`. Otherwise moves `to` and its planes back to the point at which friction holds the
/// proxy.
template <class Walls>
bool Slide<Walls>::is_held_by_friction(const glm::dvec3& from, const Planes& first, glm::dvec3& to,
                                       Planes& planes) noexcept {
  const FrictionLoad load = load_at(frame_.world_from_volume(from), first, state_.is_sticking);
  state_.is_sticking = load.is_at_rest(state_.is_sticking);
  if (load.is_held()) return true;
  move_back(from, to, planes);
  return false;
}

/// Applies friction to a path of several stages, from waypoint `landing_` on: ends it at the first point at
/// which the walls hold the pull.
template <class Walls>
glm::dvec3 Slide<Walls>::apply_path_friction() noexcept {
  const auto waypoint = [this](int i) { return result_.path_volume[static_cast<std::size_t>(i)]; };
  const int first = std::min(landing_, result_.waypoint_count - 1), last = result_.waypoint_count - 1;
  const bool was_sticking = std::exchange(state_.is_sticking, false);
  const bool has_solids = !best_inside_.is_empty() || !state_.inside.is_empty();
  frozen_count_ = 0;  // planes met earlier in the step do not hold the proxy at the end of the path
  int slipping = -1;
  for (int i = first; i <= last; ++i) {
    const glm::dvec3 at = waypoint(i);
    inside_ = has_solids ? solids_at(at) : ShapeSet{};
    planes_at(at, k_touch * voxel_mm_, planes_);
    if (planes_.count == 0) continue;  // lifted off the walls between two stages
    const FrictionLoad load = load_at(frame_.world_from_volume(at), planes_, was_sticking && i == first);
    if (!load.is_held()) {
      slipping = i;
      continue;
    }
    state_.is_sticking = i == first && load.is_at_rest(was_sticking);
    if (slipping < 0) {
      result_.waypoint_count = i + 1;
      return at;
    }
    // Finds the point between the last slipping waypoint and this one at which friction holds the pull, along
    // the walls of this one.
    const glm::dvec3 from = waypoint(slipping);
    glm::dvec3 to = at, reached = from;
    moved_planes_.copy_from(planes_);
    move_back(from, to, moved_planes_);
    Planes begin;
    begin.copy_from(moved_planes_);
    const auto path = result_.path_volume;
    result_.waypoint_count = slipping + 1;
    if (has_solids) inside_ = solids_at(from);
    if (update_planes(begin, from, frame_.vector_world_from_volume(from - to)) &&
        advance(from, to, begin, moved_planes_, reached))
      return to;
    // Other walls are in between, for example if a tool rolls over an edge. If they hold the pull at the
    // point where they stopped the proxy, the path ends there. Otherwise it continues to this waypoint, which
    // holds.
    const glm::dvec3 stopped = waypoint(result_.waypoint_count - 1);
    if (has_solids) inside_ = solids_at(stopped);
    planes_at(stopped, k_touch * voxel_mm_, planes_);
    if (planes_.count > 0 && load_at(frame_.world_from_volume(stopped), planes_, false).is_held())
      return stopped;
    result_.path_volume = path;
    result_.waypoint_count = i + 1;
    return at;
  }
  return waypoint(last);
}

}  // namespace
}  // namespace trephine::haptics
