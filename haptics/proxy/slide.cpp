// One file: one iteration and its proofs, a template over the walls, which is compiled in one place.
#include "haptics/proxy/slide.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <utility>

#include "haptics/proxy/friction.h"
#include "haptics/proxy/wall_steps.h"

namespace trephine::haptics {

namespace {

constexpr double k_gap = 1e-7;      // voxels: how far before a wall the proxy rests
constexpr double k_touch = 2e-3;    // voxels: nearer than this is on the wall
constexpr double k_landing = 1e-3;  // voxels: how near to a wall a straight way must get
static_assert(k_landing < k_touch, "a way that a wall stopped must end where that wall is touched");
constexpr double k_settled = 2e-4;  // voxels: the Newton step whose square is nothing
constexpr double k_exact = 1e-7;    // voxels: what may be left
constexpr int k_max_stages = 8;     // legs of surface a step may run along
constexpr int k_max_newton = 8;     // Newton steps a stage
constexpr double k_stage = 1.5;     // voxels: the longest leg of surface
constexpr double k_shortest_stage = 0.01;

struct FrozenPlane {
  glm::dvec3 point_world, normal;
};

/// The slide of one servo step: from the last proxy toward the HIP, straight until walls stop it, then along
/// them. Lives for one step.
template <class Walls>
class Slide {
 public:
  /// `base`: the frame of the state and of the path that is told; `walls` may be in another.
  Slide(const TouchScene& scene, Walls& walls, const volume::Frame& base, ProxyState& state,
        const glm::dvec3& hip_world, ProxyStep& result) noexcept
      : scene_(scene),
        walls_(walls),
        frame_(walls_.frame()),
        base_(base),
        state_(state),
        hip_world_(hip_world),
        hip_(frame_.volume_from_world(hip_world)),
        result_(result) {
    const glm::dvec3 spacing = frame_.spacing();
    voxel_mm_ = std::min(std::min(spacing.x, spacing.y), spacing.z);
  }

  void run() noexcept;

 private:
  double energy(const glm::dvec3& p) const noexcept {
    const glm::dvec3 d = frame_.vector_world_from_volume(hip_ - p);
    return glm::dot(d, d);
  }
  /// mm: the same along every axis and for every wall, whatever their voxels.
  double landing() const noexcept { return k_landing * voxel_mm_; }
  bool is_elsewhere() const noexcept { return &frame_ != &base_; }
  /// A point of the walls' frame in the volume's.
  glm::dvec3 in_volume(const glm::dvec3& p) const noexcept {
    if (!is_elsewhere()) return p;
    return base_.volume_from_world(p == hip_ ? hip_world_ : frame_.world_from_volume(p));
  }
  /// The path is told in the volume's frame, and begins and ends where the state says.
  void report_path() noexcept {
    if (!is_elsewhere()) return;
    for (int i = 0; i < result_.waypoint_count; ++i) {
      glm::dvec3& p = result_.path_volume[static_cast<std::size_t>(i)];
      p = i == 0 && p == start_ ? before_ : in_volume(p);
    }
  }
  void add(const glm::dvec3& p) noexcept {
    if (result_.waypoint_count < k_max_waypoints)
      result_.path_volume[static_cast<std::size_t>(result_.waypoint_count++)] = p;
  }
  /// Keeps the nearest waypoint and what touches there.
  void add_waypoint(const glm::dvec3& p) noexcept {
    const double e = energy(p);
    if (e < best_energy_) {
      best_energy_ = e;
      best_count_ = result_.waypoint_count;
      best_inside_ = inside_;
    }
  }
  bool has_friction(const Wall& wall) const noexcept {
    const Material& material = material_of(scene_, wall.shape, side_of(wall.is_back));
    return material.static_friction > 0 || material.dynamic_friction > 0;
  }
  void touch(const Plane& plane) noexcept {
    result_.shape = plane.wall.shape;
    result_.side = side_of(plane.wall.is_back);
    result_.normal_world = -plane.normal;
  }
  /// Newton's steps square their error: p after q leaves about p^3 / q^2.
  bool is_last(double square, double square_before) const noexcept {
    const double unit = voxel_mm_ * voxel_mm_;
    if (square < k_settled * k_settled * unit) return true;
    return square < k_short_step * k_short_step * unit &&
           square * square * square < k_exact * k_exact * unit * square_before * square_before;
  }
  /// The shapes in whose solid p lies.
  ShapeSet solids_at(const glm::dvec3& p) noexcept {
    ShapeSet found;
    for (int s = walls_.next_shape(0); s < ShapeSet::k_most; s = walls_.next_shape(s + 1))
      if (walls_.is_solid(s, p)) found.flip(s);
    return found;
  }
  bool begin() noexcept;
  void planes_at(const glm::dvec3& p, double within, Planes& planes) noexcept;
  void plane_of(const Wall& wall, const glm::dvec3& p, Plane& plane) noexcept;
  double farthest_back() const noexcept { return 16 * k_stage * k_stage * voxel_mm_ * voxel_mm_; }
  bool look_again(Planes& planes, const glm::dvec3& at, const glm::dvec3& p) noexcept;
  bool add_flanks(const glm::dvec3& p_world, const Plane& plane, double coefficient,
                  HoldingWalls& holding) noexcept;
  FrictionLoad load_at(const glm::dvec3& p_world, const Planes& planes, bool is_static) noexcept;
  bool slide_by(const glm::dvec3& from_world, const glm::dvec3& slide, double share, glm::dvec3& to,
                Planes& planes) noexcept;
  void trail(const glm::dvec3& from, glm::dvec3& to, Planes& planes) noexcept;
  bool is_held_by_friction(const glm::dvec3& from, const Planes& first, glm::dvec3& to,
                           Planes& planes) noexcept;
  glm::dvec3 rub_path() noexcept;
  bool solve(const glm::dvec3& from, double limit, glm::dvec3& to, Planes& planes, bool& is_settled) noexcept;
  bool go(const glm::dvec3& from, const glm::dvec3& to, const Planes& first, const Planes& last,
          glm::dvec3& at) noexcept;
  bool is_short_way_free(const Plane& first, const Plane& last, const glm::dvec3& from,
                         const glm::dvec3& middle, const glm::dvec3& to,
                         const volume::QuadraticPatch::HessianBound& bound) noexcept;
  void remember(const glm::dvec3& p, const Plane& plane) noexcept;
  void finish() noexcept;

  const TouchScene& scene_;
  Walls& walls_;
  const volume::Frame &frame_, &base_;  ///< of the walls, in which all points here are, and of the volume
  ProxyState& state_;
  const glm::dvec3 hip_world_, hip_;
  glm::dvec3 start_{0.0},
      before_{0.0};  ///< the proxy of the last step, in the walls' frame and in the volume's
  ProxyStep& result_;
  double voxel_mm_;
  ShapeSet inside_, best_inside_;
  int best_count_ = 1, landing_ = 0;
  double best_energy_ = 1e300;
  Planes planes_, moved_;
  std::array<FrozenPlane, 3> met_;
  int met_count_ = 0;
  bool is_rubbed_ = false;    ///< friction has had its say
  bool is_in_solid_ = false;  ///< the point of the last planes_at() was
};

/// The first step, and a proxy over which matter has grown, start at the HIP, inside whatever is there.
template <class Walls>
bool Slide<Walls>::begin() noexcept {
  bool is_fresh = !state_.has_proxy;
  inside_ = state_.inside;
  before_ = state_.proxy_volume;
  start_ = is_elsewhere() ? frame_.volume_from_world(base_.world_from_volume(state_.proxy_volume))
                          : state_.proxy_volume;
  if (!is_fresh)
    for (int s = walls_.next_shape(0); s < ShapeSet::k_most; s = walls_.next_shape(s + 1)) {
      // A side that does not hold may have been passed by a change of the scene; one that holds is looked at
      // below.
      const bool was = inside_.contains(s);
      if (walls_.holds(s, side_of(was))) continue;
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
  add(hip_);
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
  plane.room = -inverse * plane.jet.value - k_gap * voxel_mm_;
}

/// The walls that p touches; `within` in mm. Newest first, then the frozen ones that speak against going back
/// there.
template <class Walls>
void Slide<Walls>::planes_at(const glm::dvec3& p, double within, Planes& planes) noexcept {
  int& count = planes.count;
  count = 0;
  is_in_solid_ = false;
  for (int s = walls_.next_shape(0); s < ShapeSet::k_most; s = walls_.next_shape(s + 1)) {
    const bool is_inside = inside_.contains(s);
    if (!walls_.may_hold(s, is_inside)) continue;
    typename Walls::WallList walls;
    const int found = walls_.walls_at(s, inside_, p, within, walls);
    for (int i = 0; i < found; ++i) {
      const Wall& wall = walls[static_cast<std::size_t>(i)];
      if (count == k_max_planes) {  // more than can be held at once are still looked at
        is_in_solid_ = is_in_solid_ || walls_.value_and_gradient(wall, p).value >= 0;
        continue;
      }
      Plane& plane = planes[count];
      plane_of(wall, p, plane);
      is_in_solid_ = is_in_solid_ || plane.jet.value >= 0;
      if (plane.steepness > 0 && plane.room < within) ++count;
    }
  }
  if (count == 0 || met_count_ == 0) return;
  const glm::dvec3 here = frame_.world_from_volume(p);
  for (int i = met_count_ - 1; i >= 0 && count < k_max_planes; --i) {
    const FrozenPlane& met = met_[static_cast<std::size_t>(i)];
    const glm::dvec3& normal = planes[0].normal;
    // A corner that opens outward keeps both planes; around an edge the old one means nothing.
    const double apart = glm::dot(met.normal, normal), room = glm::dot(met.normal, met.point_world - here);
    if (apart > 0.9995 || room < 0 || glm::dot(normal, met.point_world - here) > 0) continue;
    Plane& plane = planes[count++];
    plane.is_frozen = true;
    plane.normal = met.normal;
    plane.room = room;
    plane.steepness = 1;
  }
}

template <class Walls>
void Slide<Walls>::remember(const glm::dvec3& p, const Plane& plane) noexcept {
  if (met_count_ == static_cast<int>(met_.size())) {
    std::move(met_.begin() + 1, met_.end(), met_.begin());
    --met_count_;
  }
  met_[static_cast<std::size_t>(met_count_++)] = {frame_.world_from_volume(p), plane.normal};
}

/// From a point on walls to the nearest place to the HIP on them, at most `limit` mm away. Not yet proven
/// free. False when the walls let go.
template <class Walls>
bool Slide<Walls>::solve(const glm::dvec3& from, double limit, glm::dvec3& to, Planes& planes,
                         bool& is_settled) noexcept {
  const glm::dvec3 start = frame_.world_from_volume(from);
  glm::dvec3 at = start;
  to = from;
  bool only_back = false;
  is_settled = false;
  double last_square = 0;
  for (int i = 0; i < k_max_newton; ++i) {
    ++result_.counters.iterations;
    const glm::dvec3 to_hip = hip_world_ - at;
    glm::dvec3 p(0);
    if (only_back)
      p = step_back(planes);
    else
      p = planes.count == 1 ? single_step(frame_, voxel_mm_, planes[0], to_hip)
                            : joint_step(frame_, voxel_mm_, planes, to_hip);
    // Where a wall is nearly flat it may lie anywhere: no place to go to.
    if (only_back && !(glm::dot(p, p) <= farthest_back())) return false;
    // A stage ends on a sphere around its start; from there on only back to the wall.
    const glm::dvec3 far = at + p - start;
    const double square = glm::dot(far, far);
    if (!(square >= 0)) return false;
    if (!only_back && square > limit * limit) {
      p = start + (limit / std::sqrt(square)) * far - at;
      only_back = true;
    } else if (is_last(glm::dot(p, p), last_square)) {
      is_settled = !only_back;
      at += p;
      to = frame_.volume_from_world(at);
      return true;
    }
    last_square = only_back ? 0 : glm::dot(p, p);
    at += p;
    to = frame_.volume_from_world(at);
    if (!look_again(planes, to, p)) return false;
  }
  return true;
}

/// The same planes from another point, p (mm) away. False when a wall is flat there.
template <class Walls>
bool Slide<Walls>::look_again(Planes& planes, const glm::dvec3& at, const glm::dvec3& p) noexcept {
  for (int k = 0; k < planes.count; ++k) {
    Plane& plane = planes[k];
    if (plane.is_frozen) {
      plane.room -= glm::dot(plane.normal, p);
    } else {
      plane_of(plane.wall, at, plane);
      if (!(plane.steepness > 0)) return false;
    }
  }
  return true;
}

/// A groove sharper than samples can show is one smooth wall with a narrow bottom. What holds the tool there
/// are its flanks, two samples to either side. False where the wall is no such groove.
template <class Walls>
bool Slide<Walls>::add_flanks(const glm::dvec3& p_world, const Plane& plane, double coefficient,
                              HoldingWalls& holding) noexcept {
  if constexpr (requires { walls_.is_mesh(0); })
    if (walls_.is_mesh(plane.wall.shape)) return false;
  // The direction along the wall in which it bends most toward the tool.
  glm::dvec3 u, w;
  tangents(plane.normal, u, w);
  const glm::dvec3 u_voxel = frame_.vector_volume_from_world(u), w_voxel = frame_.vector_volume_from_world(w);
  const glm::dvec3 hessian_u = plane.jet.hessian_times(u_voxel), hessian_w = plane.jet.hessian_times(w_voxel);
  const double uu = glm::dot(hessian_u, u_voxel), uw = glm::dot(hessian_u, w_voxel),
               ww = glm::dot(hessian_w, w_voxel);
  const double half = 0.5 * (uu - ww), root = std::sqrt(half * half + uw * uw),
               bend = (0.5 * (uu + ww) + root) / plane.steepness;
  constexpr double k_sharp = 0.5;  // samples of bend a sample: a radius of two
  const double sample_mm = walls_.sample_mm(plane.wall);
  if (!(bend * sample_mm > k_sharp)) return false;
  const glm::dvec3 across = half >= 0 ? (half + root) * u + uw * w : uw * u + (root - half) * w;
  const double size = glm::length(across);
  if (!(size > 0)) return false;
  constexpr double k_aside = 2;  // samples: farther than the smooth reconstruction rounds a kink
  const double aside = walls_.longest_leg(plane.wall, k_aside * sample_mm);
  std::array<glm::dvec3, 2> normals;
  for (const int side : {0, 1}) {
    const glm::dvec3 at = p_world + (side == 0 ? -aside : aside) / size * across;
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

/// Splits the hand's pull among the walls that the tool touches at the place of the planes.
template <class Walls>
FrictionLoad Slide<Walls>::load_at(const glm::dvec3& p_world, const Planes& planes, bool is_static) noexcept {
  HoldingWalls holding;
  for (int k = 0; k < planes.count; ++k) {
    const Plane& plane = planes[k];
    if (plane.is_frozen || plane.room > k_touch * voxel_mm_) continue;
    const Material& material = material_of(scene_, plane.wall.shape, side_of(plane.wall.is_back));
    const double coefficient = is_static ? material.static_friction : material.dynamic_friction;
    if (!add_flanks(p_world, plane, coefficient, holding)) holding.add(plane.normal, coefficient);
  }
  return friction_load(holding, hip_world_ - p_world);
}

/// The place between `from` (a share of 0) and `to` (1) along the same walls, which `planes` are then of.
template <class Walls>
bool Slide<Walls>::slide_by(const glm::dvec3& from_world, const glm::dvec3& slide, double share,
                            glm::dvec3& to, Planes& planes) noexcept {
  glm::dvec3 at = frame_.world_from_volume(to), p = from_world + share * slide - at;
  for (int i = 0; i < k_max_newton; ++i) {
    at += p;
    to = frame_.volume_from_world(at);
    if (!look_again(planes, to, p)) return false;
    p = step_back(planes);
    if (!(glm::dot(p, p) <= farthest_back())) return false;
    if (glm::dot(p, p) < k_settled * k_settled * voxel_mm_ * voxel_mm_) break;
  }
  to = frame_.volume_from_world(at + p);
  return true;
}

/// Moves `to` and its planes back toward `from`, to where the dynamic cone of the walls just holds the pull;
/// leaves them where none is found.
template <class Walls>
void Slide<Walls>::trail(const glm::dvec3& from, glm::dvec3& to, Planes& planes) noexcept {
  const glm::dvec3 begin = frame_.world_from_volume(from), end = frame_.world_from_volume(to),
                   slide = end - begin;
  const FrictionLoad at_end = load_at(end, planes, false);
  const double length = glm::length(slide);
  if (!at_end.is_held() || at_end.limit <= 0 || !(length > 0)) return;
  constexpr double k_within = 4e-3;  // of the limit: how far inside the cone it may end
  constexpr int k_most_tries = 8;
  double low = 0, high = 1, low_excess = 1e300, high_excess = at_end.along - at_end.limit;
  Planes held, frictionless;
  held.copy_from(planes);
  frictionless.copy_from(planes);
  const glm::dvec3 frictionless_at = to;
  glm::dvec3 held_at = to, probe = to;
  double share = 1 - (1 - 0.25 * k_within) * at_end.limit / length;
  for (int i = 0; i < k_most_tries; ++i) {
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
    // Regula falsi, aimed a little into the cone, or halfway while one end is unknown.
    const double aim = -0.25 * k_within * load.limit;
    share = low_excess < 1e299 ? low + (high - low) * (low_excess - aim) / (low_excess - high_excess)
                               : 0.5 * (low + high);
  }
  to = held_at;
  planes.copy_from(held);
  // Friction takes energy: where the way there led farther from the HIP first, it goes all the way.
  if (energy(to) > energy(from)) {
    to = frictionless_at;
    planes.copy_from(frictionless);
  }
}

/// Coulomb friction on a slide along one stage (cone of Salisbury and Tarr 1997, at the proxy's own normals,
/// with each wall's own share): the proxy stays, or goes on until the cone holds it. Moves `to` and its
/// planes. True when it stays.
template <class Walls>
bool Slide<Walls>::is_held_by_friction(const glm::dvec3& from, const Planes& first, glm::dvec3& to,
                                       Planes& planes) noexcept {
  const FrictionLoad load = load_at(frame_.world_from_volume(from), first, state_.is_sticking);
  state_.is_sticking = load.is_at_rest(state_.is_sticking);
  if (load.is_held()) return true;
  trail(from, to, planes);
  return false;
}

/// Applies friction to a path of several stages, from waypoint `landing_` on: ends it at the first place
/// whose walls hold the pull.
template <class Walls>
glm::dvec3 Slide<Walls>::rub_path() noexcept {
  const auto waypoint = [this](int i) { return result_.path_volume[static_cast<std::size_t>(i)]; };
  const int first = std::min(landing_, result_.waypoint_count - 1), last = result_.waypoint_count - 1;
  const bool was_sticking = std::exchange(state_.is_sticking, false);
  const bool has_solids = !best_inside_.is_empty() || !state_.inside.is_empty();
  met_count_ = 0;  // planes met earlier in the step hold nothing at its end
  int before = -1;
  for (int i = first; i <= last; ++i) {
    const glm::dvec3 at = waypoint(i);
    inside_ = has_solids ? solids_at(at) : ShapeSet{};
    planes_at(at, k_touch * voxel_mm_, planes_);
    if (planes_.count == 0) continue;  // lifted off the walls between two stages
    const FrictionLoad load = load_at(frame_.world_from_volume(at), planes_, was_sticking && i == first);
    if (!load.is_held()) {
      before = i;
      continue;
    }
    state_.is_sticking = i == first && load.is_at_rest(was_sticking);
    if (before < 0) {
      result_.waypoint_count = i + 1;
      return at;
    }
    // Between the last place that slips and this one, along the walls of this one.
    const glm::dvec3 from = waypoint(before);
    glm::dvec3 to = at, reached = from;
    moved_.copy_from(planes_);
    trail(from, to, moved_);
    Planes begin;
    begin.copy_from(moved_);
    result_.waypoint_count = before + 1;
    if (has_solids) inside_ = solids_at(from);
    if (look_again(begin, from, frame_.vector_world_from_volume(from - to)))
      go(from, to, begin, moved_, reached);
    return waypoint(result_.waypoint_count - 1);
  }
  return waypoint(last);
}

/// Both legs of a short way along one wall, proven by the wall's gradients at its ends and a bound of its
/// bending.
template <class Walls>
bool Slide<Walls>::is_short_way_free(const Plane& first, const Plane& last, const glm::dvec3& from,
                                     const glm::dvec3& middle, const glm::dvec3& to,
                                     const volume::QuadraticPatch::HessianBound& bound) noexcept {
  const glm::dvec3 up = middle - from, down = middle - to;
  const volume::ValueAndGradient end = walls_.value_and_gradient(last.wall, to);
  const double c = first.jet.value + rounding_of(first.jet, bound), d = end.value + rounding_of(end, bound);
  return c < 0 && d < 0 && free_step(c, glm::dot(first.jet.gradient, up), bound.along(up)) >= 1 &&
         free_step(d, glm::dot(end.gradient, down), bound.along(down)) >= 1;
}

/// From one place on the walls to another through a point lifted off them, each leg proven. `at`: how far it
/// came.
template <class Walls>
bool Slide<Walls>::go(const glm::dvec3& from, const glm::dvec3& to, const Planes& first, const Planes& last,
                      glm::dvec3& at) noexcept {
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
    // The way rises by what bending may take from it in half its length.
    bound = walls_.hessian_bound(first[k].wall, span, is_whole);
    const double curved = bound.along(along) / 8;
    const double slope = std::max(
        0.0, 0.5 * std::max(glm::dot(first[k].jet.gradient, along), -glm::dot(last[k].jet.gradient, along)));
    lift = std::max(lift, (curved + slope) / std::min(first[k].steepness, last[k].steepness));
  }
  const double size = glm::length(out);
  if (!(size > 1e-6)) return false;
  // Between several walls the way out is steeper than to each of them.
  double least = 1;
  if (count > 1)
    for (int k = 0; k < count; ++k) least = std::min(least, -glm::dot(out, first[k].normal) / size);
  lift = std::min((1.5 * lift + 1e-5 * voxel_mm_) / std::max(0.1, least), 0.5 * voxel_mm_);
  const glm::dvec3 middle = from + 0.5 * along + frame_.vector_volume_from_world(lift / size * out);
  if (count == 1 && is_whole && walls_.is_only_wall(first[0].wall)) {
    walls_.widen(first[0].wall, span, middle, bound, is_whole);
    if (is_whole && is_short_way_free(first[0], last[0], from, middle, to, bound)) {
      add(middle);
      add(to);
      at = to;
      return true;
    }
  }
  ShapeSet inside = inside_;
  const Reach up = walls_.reach(from, middle, inside, landing());
  if (up.is_blocked) {
    at = from + up.t * (middle - from);
    if (up.t <= 0) return false;
    inside_ = inside;
    add(at);
    return false;
  }
  add(middle);
  inside_ = inside;
  at = middle;
  const Reach down = walls_.reach(middle, to, inside, landing());
  if (down.is_blocked) {
    at = middle + down.t * (to - middle);
    if (down.t > 0) {
      inside_ = inside;
      add(at);
    }
    return false;
  }
  inside_ = inside;
  at = to;
  add(to);
  return true;
}

template <class Walls>
void Slide<Walls>::run() noexcept {
  if (!begin()) return;
  glm::dvec3 at = start_;
  add(at);
  add_waypoint(at);
  Planes &planes = planes_, &moved = moved_;
  for (int stage = 0; stage < k_max_stages && result_.waypoint_count + 4 <= k_max_waypoints; ++stage) {
    // Straight to the HIP, unless a wall that is touched here faces it.
    if (stage > 0) planes_at(at, k_touch * voxel_mm_, planes);
    const glm::dvec3 to_hip = hip_world_ - frame_.world_from_volume(at);
    bool is_facing = false;
    for (int k = 0; k < planes.count; ++k)
      if (const Plane& p = planes[k]; !p.is_frozen)
        is_facing = is_facing || glm::dot(p.normal, to_hip) > std::max(p.room, 0.0);
    if (!is_facing) {
      const Reach straight = walls_.reach(at, hip_, inside_, landing());
      if (!straight.is_blocked) {
        add(hip_);
        add_waypoint(hip_);
        break;
      }
      if (straight.t > 0) {
        at += straight.t * (hip_ - at);
        add(at);
        add_waypoint(at);
        if (result_.shape < 0) landing_ = result_.waypoint_count - 1;
      }
      planes_at(at, 4 * k_touch * voxel_mm_, planes);
      if constexpr (requires { walls_.is_mesh(0); }) {
        // What stopped the way holds, whatever else is near.
        bool is_held = !walls_.is_mesh(straight.wall.shape) || planes.count == k_max_planes;
        for (int k = 0; k < planes.count; ++k)
          is_held = is_held || (!planes[k].is_frozen && planes[k].wall == straight.wall);
        if (!is_held) plane_of(straight.wall, at, planes[planes.count++]);
      }
      if (planes.count == 0) {
        // A proof that took too long: hold the plane of what stopped it.
        plane_of(straight.wall, at, planes[0]);
        planes.count = planes[0].steepness > 0 ? 1 : 0;
      }
      if (planes.count == 0) {
        // Flat matter without a normal: held where it is, facing back along the way.
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
    if (result_.shape < 0) touch(planes[0]);
    // Along the walls, as far as it leads nearer.
    const double energy_here = energy(at);
    glm::dvec3 to = at;
    bool is_settled = false, is_lower = false;
    double gone = 0;
    double longest = k_stage * voxel_mm_;
    for (int k = 0; k < planes.count; ++k)
      if (!planes[k].is_frozen) longest = walls_.longest_leg(planes[k].wall, longest);
    for (double limit = longest; limit > k_shortest_stage * voxel_mm_; limit = 0.3 * std::min(limit, gone)) {
      moved.copy_from(planes);
      if (!solve(at, limit, to, moved, is_settled)) break;
      gone = glm::length(frame_.vector_world_from_volume(to - at));
      is_lower = energy(to) < energy_here;
      if (is_lower || gone < 1e-9 * voxel_mm_) break;
    }
    if (!is_lower) break;
    if (stage == 0 && is_settled && landing_ == 0 && state_.had_contact && has_friction(planes[0].wall)) {
      is_rubbed_ = true;
      if (is_held_by_friction(at, planes, to, moved)) break;
    }
    const glm::dvec3 before = at;
    const bool has_arrived = go(before, to, planes, moved, at);
    add_waypoint(at);
    if (has_arrived) touch(moved[0]);
    if (is_rubbed_) break;  // friction has said how far; what stopped the way earlier is for the next step
    if (has_arrived) {
      // Settled on walls that all still face the HIP: nothing is nearer.
      if (is_settled) {
        const glm::dvec3 rest = hip_world_ - frame_.world_from_volume(at);
        bool is_held = true;
        for (int k = 0; k < moved.count; ++k)
          is_held = is_held && !moved[k].is_frozen && glm::dot(moved[k].normal, rest) > 0;
        if (is_held) break;
      }
    } else if (at == before) {
      break;
    }
    remember(before, planes[0]);
  }
  finish();
}

/// The nearest waypoint, then friction along the way to it.
template <class Walls>
void Slide<Walls>::finish() noexcept {
  result_.waypoint_count = best_count_;
  glm::dvec3 proxy = result_.path_volume[static_cast<std::size_t>(best_count_ - 1)];
  result_.has_contact = proxy != hip_;
  ShapeSet inside = best_inside_;
  if (!result_.has_contact) {
    result_.normal_world = glm::dvec3(0);
    result_.shape = -1;
    result_.side = Side::none;
  } else if (state_.had_contact) {
    if (!is_rubbed_ && has_friction({result_.shape, false, result_.side == Side::back})) {
      proxy = rub_path();
      // A leg that friction shortened ends where rounding put it: look again.
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
