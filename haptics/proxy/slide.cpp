#include "haptics/proxy/slide.h"

#include "haptics/proxy/slide_crease_impl.h"
#include "haptics/proxy/slide_friction_impl.h"
#include "haptics/proxy/slide_impl.h"

namespace trephine::haptics {

namespace {

/// Begins a step. The first step, and any step in which matter has grown over the proxy, sets the proxy to
/// the HIP, even inside a solid, and returns false: there is no slide.
template <class Walls>
bool Slide<Walls>::begin() noexcept {
  bool is_fresh = !state_.has_proxy;
  inside_ = state_.inside;
  start_volume_ = state_.proxy_volume;
  start_ = has_own_frame() ? frame_.volume_from_world(base_.world_from_volume(state_.proxy_volume))
                           : state_.proxy_volume;
  if (!is_fresh)
    for (int s = walls_.next_shape(0); s < ShapeSet::k_max; s = walls_.next_shape(s + 1)) {
      // After a change of the scene, the proxy may be on the other side of a surface that does not block it.
      // Surfaces that block the proxy are tested below.
      const bool was = inside_.contains(s);
      if (walls_.blocks(s, side_of(was))) continue;
      inside_.set(s, walls_.is_solid(s, start_));
    }
  if (!is_fresh) {
    planes_at(start_, k_touch * voxel_mm_, planes_);
    if (!is_in_solid_) return true;
    result_.is_buried = true;
  }
  state_.begin_at(in_volume(hip_));
  state_.inside = solids_at(hip_);
  result_.proxy_world = hip_world_;
  append(hip_);
  report_path();
  return false;
}

template <class Walls>
void Slide<Walls>::plane_of(const Wall& wall, const glm::dvec3& p, Plane& plane) noexcept {
  plane.wall = wall;
  plane.is_frozen = false;
  plane.jet = walls_.jet(wall, p);
  const glm::dvec3 gradient = frame_.gradient_world_from_volume(plane.jet.gradient);
  plane.steepness = glm::length(gradient);
  if (!(plane.steepness > 0)) return;
  const double inverse = 1 / plane.steepness;
  plane.normal = inverse * gradient;
  plane.distance = -inverse * plane.jet.value - k_gap * voxel_mm_;
}

/// Sets `planes`: first the walls within `within` mm of p, then the sheet or stair-step that stopped the last
/// motion, then frozen planes, newest first. Frozen planes prevent a return to the walls that the slide has
/// left. Sets is_in_solid_.
template <class Walls>
void Slide<Walls>::planes_at(const glm::dvec3& p, double within, Planes& planes) noexcept {
  int& count = planes.count;
  count = 0;
  is_in_solid_ = false;
  for (int s = walls_.next_shape(0); s < ShapeSet::k_max; s = walls_.next_shape(s + 1)) {
    const bool is_inside = inside_.contains(s);
    if (!walls_.may_block(s, is_inside)) continue;
    typename Walls::WallList walls;
    const int found = walls_.walls_at(s, inside_, p, within, walls);
    for (int i = 0; i < found; ++i) {
      const Wall& wall = walls[static_cast<std::size_t>(i)];
      if (count == k_max_planes) {  // further walls only determine is_in_solid_
        is_in_solid_ = is_in_solid_ || walls_.value_and_gradient(wall, p).value >= 0;
        continue;
      }
      Plane& plane = planes[count];
      plane_of(wall, p, plane);
      is_in_solid_ = is_in_solid_ || plane.jet.value >= 0;
      if (plane.steepness > 0 && plane.distance < within) ++count;
    }
  }
  if (stopping_.shape >= 0 && count < k_max_planes) {
    bool is_known = false;
    for (int k = 0; k < count; ++k) is_known = is_known || planes[k].wall == stopping_;
    Plane& plane = planes[count];
    if (!is_known) plane_of(stopping_, p, plane);
    if (!is_known && plane.steepness > 0 && plane.distance < within) ++count;
  }
  if (count == 0 || frozen_count_ == 0) return;
  const glm::dvec3 here = frame_.world_from_volume(p);
  for (int i = frozen_count_ - 1; i >= 0 && count < k_max_planes; --i) {
    const FrozenPlane& old = frozen_[static_cast<std::size_t>(i)];
    const glm::dvec3& normal = planes[0].normal;
    // In a concave corner both planes hold the proxy. At a convex edge the frozen plane does not apply.
    const double cosine = glm::dot(old.normal, normal),
                 distance = glm::dot(old.normal, old.point_world - here);
    if (cosine > 0.9995 || distance < 0 || glm::dot(normal, old.point_world - here) > 0) continue;
    Plane& plane = planes[count++];
    plane.is_frozen = true;
    plane.normal = old.normal;
    plane.distance = distance;
    plane.steepness = 1;
  }
}

template <class Walls>
void Slide<Walls>::freeze(const glm::dvec3& p, const Plane& plane) noexcept {
  if (frozen_count_ == static_cast<int>(frozen_.size())) {
    std::move(frozen_.begin() + 1, frozen_.end(), frozen_.begin());
    --frozen_count_;
  }
  frozen_[static_cast<std::size_t>(frozen_count_++)] = {frame_.world_from_volume(p), plane.normal};
}

/// Finds the point on the walls that is nearest to the HIP, at most `limit` mm from the point `from` on the
/// walls. The motion to it is not yet proven free. Returns false if Newton's method has no direction, for
/// example where the field of a wall has no gradient.
template <class Walls>
bool Slide<Walls>::solve(const glm::dvec3& from, double limit, glm::dvec3& to, Planes& planes,
                         bool& is_settled) noexcept {
  const glm::dvec3 start = frame_.world_from_volume(from);
  glm::dvec3 at = start;
  to = from;
  bool is_at_limit = false;
  is_settled = false;
  double last_square = 0;
  glm::dvec3 last_step(0);
  for (int i = 0; i < k_max_newton; ++i) {
    ++result_.counters.iterations;
    const glm::dvec3 to_hip = hip_world_ - at;
    glm::dvec3 p(0);
    if (is_at_limit)
      p = step_to_walls(planes);
    else
      p = planes.count == 1 ? single_step(frame_, voxel_mm_, planes[0], to_hip)
                            : joint_step(frame_, voxel_mm_, planes, to_hip);
    // At an edge the nearest point of each face may be beyond the other face, so that steps alternate between
    // the faces. Halved steps find the edge.
    if (const double back = -glm::dot(p, last_step);
        back > 0.5 * glm::dot(p, p) && 2 * glm::dot(p, p) > glm::dot(last_step, last_step))
      p *= 0.5;
    last_step = p;
    // The step to a wall whose field has almost no gradient may be very long: there is no target.
    if (is_at_limit && !(glm::dot(p, p) <= max_square_to_walls())) return false;
    // A stage that would be longer than `limit` ends on the sphere of that radius around its start. From
    // there only steps onto the walls are made.
    const glm::dvec3 far = at + p - start;
    const double square = glm::dot(far, far);
    if (!(square >= 0)) return false;
    if (!is_at_limit && square > limit * limit) {
      p = start + (limit / std::sqrt(square)) * far - at;
      is_at_limit = true;
    } else if (has_converged(glm::dot(p, p), last_square)) {
      is_settled = !is_at_limit;
      at += p;
      to = frame_.volume_from_world(at);
      return true;
    }
    last_square = is_at_limit ? 0 : glm::dot(p, p);
    at += p;
    to = frame_.volume_from_world(at);
    if (!update_planes(planes, to, p)) return false;
  }
  return true;
}

/// Updates the planes to the point `at`, after a displacement by `p` (mm, world). Returns false if the field
/// of a wall has no gradient at that point.
template <class Walls>
bool Slide<Walls>::update_planes(Planes& planes, const glm::dvec3& at, const glm::dvec3& p) noexcept {
  for (int k = 0; k < planes.count; ++k) {
    Plane& plane = planes[k];
    if (plane.is_frozen) {
      plane.distance -= glm::dot(plane.normal, p);
    } else {
      plane_of(plane.wall, at, plane);
      if (!(plane.steepness > 0)) return false;
    }
  }
  return true;
}

/// Returns true if both legs of a short motion along one wall are free. The proof uses the wall's gradients
/// at the ends of the motion, and a bound of the wall's curvature.
template <class Walls>
bool Slide<Walls>::is_short_motion_free(const Plane& first, const Plane& last, const glm::dvec3& from,
                                        const glm::dvec3& middle, const glm::dvec3& to,
                                        const volume::QuadraticPatch::HessianBound& bound) noexcept {
  const glm::dvec3 up = middle - from, down = middle - to;
  const volume::ValueAndGradient end = walls_.value_and_gradient(last.wall, to);
  const double c = first.jet.value + rounding_of(first.jet, bound), d = end.value + rounding_of(end, bound);
  return c < 0 && d < 0 && free_step(c, glm::dot(first.jet.gradient, up), bound.along(up)) >= 1 &&
         free_step(d, glm::dot(end.gradient, down), bound.along(down)) >= 1;
}

/// Moves from one point on the walls to another, through a point that is lifted off the walls. Both legs are
/// proven free. `at`: output, the point reached. Returns false if a wall stopped the motion, or if the walls
/// have no common outward direction.
template <class Walls>
bool Slide<Walls>::advance(const glm::dvec3& from, const glm::dvec3& to, const Planes& first,
                           const Planes& last, glm::dvec3& at) noexcept {
  const glm::dvec3 along = to - from;
  const int count = first.count;
  glm::dvec3 out(0);
  double lift = 0;
  const typename Walls::Span span(from, to);
  volume::QuadraticPatch::HessianBound bound;
  bool is_whole = false;
  for (int k = 0; k < count; ++k) {
    out -= first[k].normal + last[k].normal;
    if (first[k].is_frozen) continue;
    // The lift covers the largest height by which a curved wall may rise above the middle of the motion.
    bound = walls_.hessian_bound(first[k].wall, span, is_whole);
    const double curved = bound.along(along) / 8;
    const double slope = std::max(
        0.0, 0.5 * std::max(glm::dot(first[k].jet.gradient, along), -glm::dot(last[k].jet.gradient, along)));
    lift = std::max(lift, (curved + slope) / std::min(first[k].steepness, last[k].steepness));
  }
  if (is_creased(first)) turn_away_from_walls(first, out);
  const double size = glm::length(out);
  if (!(size > 1e-6)) return false;
  // Between several walls the outward direction is oblique to each of them.
  double least = 1;
  if (count > 1)
    for (int k = 0; k < count; ++k) least = std::min(least, -glm::dot(out, first[k].normal) / size);
  lift = std::min((1.5 * lift + 1e-5 * voxel_mm_) / std::max(0.1, least), 0.5 * voxel_mm_);
  const glm::dvec3 middle = from + 0.5 * along + frame_.vector_volume_from_world(lift / size * out);
  if (count == 1 && is_whole && walls_.is_only_wall(first[0].wall)) {
    walls_.widen(first[0].wall, span, middle, bound, is_whole);
    if (is_whole && is_short_motion_free(first[0], last[0], from, middle, to, bound)) {
      append(middle);
      append(to);
      at = to;
      return true;
    }
  }
  ShapeSet inside = inside_;
  const Reach up = walls_.reach(from, middle, inside, landing());
  if (up.is_blocked) {
    at = from + up.t * (middle - from);
    if (up.t > 0) {
      inside_ = inside;
      append(at);
    }
    climb_step(up.wall, first, at);
    return false;
  }
  append(middle);
  inside_ = inside;
  at = middle;
  const Reach down = walls_.reach(middle, to, inside, landing());
  if (down.is_blocked) {
    at = middle + down.t * (to - middle);
    if (down.t > 0) {
      inside_ = inside;
      append(at);
    }
    climb_step(down.wall, first, at);
    return false;
  }
  inside_ = inside;
  at = to;
  append(to);
  return true;
}

/// Returns the free share `t` of the motion from `at` to the HIP. On a very long motion it is reduced by the
/// possible rounding, so that the end of the free part is free.
template <class Walls>
double Slide<Walls>::share_less_rounding(double t, const glm::dvec3& at) const noexcept {
  constexpr double k_long = 1000, k_rounding = 4e-12;  // voxels; share of the motion
  const glm::dvec3 offset = hip_ - at;
  return glm::dot(offset, offset) > k_long * k_long ? t - k_rounding : t;
}

template <class Walls>
void Slide<Walls>::run() noexcept {
  if (!begin()) return;
  glm::dvec3 at = start_;
  append(at);
  record_if_nearest(at);
  Planes &planes = planes_, &moved = moved_planes_;
  double longest_creased = 1e300;  // mm
  for (int stage = 0; stage < k_max_stages && result_.waypoint_count + 4 <= k_max_waypoints; ++stage) {
    // Moves straight to the HIP, unless the motion would lead into a touched wall.
    if (stage > 0) planes_at(at, k_touch * voxel_mm_, planes);
    const glm::dvec3 to_hip = hip_world_ - frame_.world_from_volume(at);
    bool is_facing = false;
    for (int k = 0; k < planes.count; ++k)
      if (const Plane& p = planes[k]; !p.is_frozen)
        is_facing = is_facing || glm::dot(p.normal, to_hip) > std::max(p.distance, 0.0);
    if (!is_facing) {
      const Reach straight = walls_.reach(at, hip_, inside_, landing());
      if (!straight.is_blocked) {
        append(hip_);
        record_if_nearest(hip_);
        break;
      }
      if (const double t = share_less_rounding(straight.t, at); t > 0) {
        at += t * (hip_ - at);
        append(at);
        record_if_nearest(at);
        if (result_.shape < 0) landing_ = result_.waypoint_count - 1;
      }
      climb_step(straight.wall, planes, at);
      planes_at(at, 4 * k_touch * voxel_mm_, planes);
      if constexpr (requires { walls_.is_mesh(0); }) {
        // Adds the facet that stopped the motion to the planes, unless a near facet has the same normal.
        if (walls_.is_mesh(straight.wall.shape) && planes.count < k_max_planes) {
          Plane& stopping = planes[planes.count];
          plane_of(straight.wall, at, stopping);
          bool is_known = !(stopping.steepness > 0);
          for (int k = 0; k < planes.count; ++k)
            is_known = is_known || (!planes[k].is_frozen && planes[k].wall.shape == straight.wall.shape &&
                                    glm::dot(planes[k].normal, stopping.normal) > k_same_normal);
          if (!is_known) ++planes.count;
        }
      }
      if (planes.count == 0) {
        // The proof of the motion reached its limit of work before a touched wall. Uses the plane of the wall
        // at which the proof ended.
        plane_of(straight.wall, at, planes[0]);
        planes.count = planes[0].steepness > 0 ? 1 : 0;
      }
      if (planes.count == 0) {
        // The field is flat at the wall that stopped the proxy, so that the wall has no normal. The proxy
        // stays, and the direction from the HIP back to the proxy serves as the normal.
        if (result_.shape < 0) {
          const glm::dvec3 back = frame_.world_from_volume(at) - hip_world_;
          const double length = glm::length(back);
          result_.shape = straight.wall.shape;
          result_.side = side_of(straight.wall.is_back);
          if (length > 0) result_.normal_world = back / length;
        }
        break;
      }
    }
    if (result_.shape < 0) set_touched(planes[0]);
    // Moves along the walls, as long as that leads nearer to the HIP.
    const double energy_here = energy(at);
    glm::dvec3 to = at;
    bool is_settled = false, is_lower = false;
    double slid = 0;
    double longest = std::min(k_stage * voxel_mm_, longest_creased);
    for (int k = 0; k < planes.count; ++k)
      if (!planes[k].is_frozen) longest = walls_.longest_leg(planes[k].wall, longest);
    const bool has_sheets = is_creased(planes);
    for (double limit = longest; limit > k_shortest_stage * voxel_mm_; limit = 0.3 * std::min(limit, slid)) {
      moved.copy_from(planes);
      if (!solve(at, limit, to, moved, is_settled)) {
        if (!has_sheets) break;
        slid = limit;
        continue;
      }
      slid = glm::length(frame_.vector_world_from_volume(to - at));
      is_lower = energy(to) < energy_here;
      if (is_lower || slid < 1e-9 * voxel_mm_) break;
    }
    if (!is_lower) break;
    if (stage == 0 && is_settled && landing_ == 0 && state_.had_contact && has_friction(planes[0].wall)) {
      is_friction_applied_ = true;
      if (is_held_by_friction(at, planes, to, moved)) break;
    }
    const glm::dvec3 before = at;
    const Wall last_stopping = std::exchange(stopping_, {});
    const bool has_arrived = advance(before, to, planes, moved, at);
    record_if_nearest(at);
    if (has_arrived) set_touched(moved[0]);
    if (is_friction_applied_) {
      // Friction determined the end of the motion. If a wall stopped the motion earlier, the next servo step
      // continues; only a stair-step of the solid is climbed now.
      if (!has_arrived && stopping_.is_step) climb_to(to, at);
      break;
    }
    if (has_arrived) {
      // The point has converged, and the HIP is behind all of its walls: no point is nearer.
      if (is_settled) {
        const glm::dvec3 rest = hip_world_ - frame_.world_from_volume(at);
        bool is_held = true;
        for (int k = 0; k < moved.count; ++k)
          is_held = is_held && !moved[k].is_frozen && glm::dot(moved[k].normal, rest) > 0;
        if (is_held) break;
      }
    } else if (at == before && (stopping_.shape < 0 || stopping_ == last_stopping)) {
      // A sheet that ended during the leg led the proxy into another wall. The next leg is shorter.
      longest_creased = 0.3 * slid;
      if (!has_sheets || !(longest_creased > k_shortest_stage * voxel_mm_)) break;
      continue;
    }
    freeze(before, planes[0]);
  }
  finish();
}

/// Ends at the waypoint nearest to the HIP, with friction along the path to it.
template <class Walls>
void Slide<Walls>::finish() noexcept {
  stopping_ = {};
  result_.waypoint_count = best_count_;
  glm::dvec3 proxy = result_.path_volume[static_cast<std::size_t>(best_count_ - 1)];
  result_.has_contact = proxy != hip_;
  ShapeSet inside = best_inside_;
  if (!result_.has_contact) {
    result_.normal_world = glm::dvec3(0);
    result_.shape = -1;
    result_.side = Side::none;
  } else if (state_.had_contact) {
    if (!is_friction_applied_ && has_friction({result_.shape, false, result_.side == Side::back})) {
      proxy = apply_path_friction();
      // Rounding may have moved the end of a leg that friction shortened: it is tested again.
      if (const int last = result_.waypoint_count - 1; last > 0) {
        const glm::dvec3 start = result_.path_volume[static_cast<std::size_t>(last - 1)];
        ShapeSet after = solids_at(start);
        if (walls_.reach(start, proxy, after, landing()).is_blocked) {
          proxy = start;
          --result_.waypoint_count;
        }
      }
      inside = solids_at(proxy);
    }
  } else {
    state_.is_sticking = true;
  }
  state_.had_contact = result_.has_contact;
  state_.inside = inside;
  result_.path_volume[static_cast<std::size_t>(result_.waypoint_count - 1)] = proxy;
  result_.proxy_world = frame_.world_from_volume(proxy);
  report_path();
  state_.proxy_volume = result_.path_volume[static_cast<std::size_t>(result_.waypoint_count - 1)];
}

}  // namespace

template <class Walls>
void slide(const TouchScene& scene, Walls& walls, const volume::Frame& base, ProxyState& state,
           const glm::dvec3& hip_world, ProxyStep& result) noexcept {
  Slide<Walls>(scene, walls, base, state, hip_world, result).run();
}

template void slide(const TouchScene&, SmoothWalls&, const volume::Frame&, ProxyState&, const glm::dvec3&,
                    ProxyStep&) noexcept;
template void slide(const TouchScene&, SceneWalls&, const volume::Frame&, ProxyState&, const glm::dvec3&,
                    ProxyStep&) noexcept;

}  // namespace trephine::haptics
