#include "haptics/proxy/shell_proxy.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <utility>

#include "haptics/proxy/near_points.h"
#include "haptics/proxy/nearest_motion.h"
#include "haptics/proxy/rigid_step.h"

namespace trephine::haptics {

using glm::dquat;
using glm::dvec3;

namespace {

// In voxels of the scene's frame (SceneLayout::frame()), unless another unit is given.
constexpr double k_gap = 2e-3;          // distance that points keep from walls
constexpr double k_min_gain = 1e-4;     // a pose counts if it reduces the distance to the hand by more
constexpr double k_slow = 1e-3;         // a smaller gain of a round that no wall stopped ends the rounds
constexpr double k_min_motion = 2e-4;   // a smaller motion ends the rounds
constexpr double k_normals_apart = 4;   // distance that counts as much as 60 degrees between normals
constexpr double k_longest_turn = 0.1;  // rad per round
// In units of margins.
constexpr double k_first_margin = 0.18;  // motion of the points near matter before they are found again
constexpr double k_next_margin = 0.45;   // largest later margin
constexpr double k_spare = 1.5;  // later margins are longer than the rest of the motion by this factor

constexpr double k_least_change = 2e-5;  // of a push by friction; a smaller change ends the search
constexpr int k_rounds = 8, k_friction_turns = 8, k_sweeps = 8, k_max_collections = 4;
constexpr std::size_t k_max_bounds = 16;
// Largest number of exact searches for one motion, each of which costs as much as 30 proofs. A motion that
// requires more is shortened. The second number applies to the last attempt.
constexpr int k_max_searches = 60, k_last_try_searches = NearPoints::k_max;
constexpr std::uint32_t k_unknown_count = ~0u;  // ProxyState::balls_inside of a step that left points out

/// Bound of a wall near a point on a motion, and the friction there.
struct Bound : MotionBound {
  dvec3 arm;  ///< mm, from the position of the tool
  dvec3 tangents[2];
  double slip[2] = {0, 0};  ///< friction along the tangents, mm
  double room, friction;
  std::size_t near;  ///< index in NearPoints
};

/// One step of a shell.
class Shell {
 public:
  Shell(const TouchScene& scene, SceneWalls& walls, ProxyState& state, const ProxyInput& input,
        ProxyCounters& counters) noexcept
      : scene_(scene),
        shell_(*scene.tool->shell()),
        walls_(walls),
        state_(state),
        counters_(counters),
        square_(scene.tool->gyration_square()),
        voxel_(walls.frame().spacing().x),
        hand_{input.hip_world, unit_of(input.orientation)},
        near_(scene, walls, counters) {
    walls.use(cache_);
  }

  /// Starts at the hand, even inside a solid.
  void begin(const volume::Frame& base) noexcept {
    state_.begin_at(base.volume_from_world(hand_.position_world));
    tool_ = hand_;
    find_near();
  }
  void resume(const Placement& tool) noexcept { tool_ = tool, is_found_ = false; }
  const Placement& pose() const noexcept { return tool_; }
  const Placement& hand() const noexcept { return hand_; }
  /// Returns true if more points are in a solid than in the previous step. Returns false if points were left
  /// out in either step, since the counts cannot be compared; covered points then do not touch the solid
  /// until they have left it.
  bool has_grown() noexcept {
    const std::uint32_t before = state_.balls_inside;
    find_near();
    return state_.balls_inside != k_unknown_count && state_.balls_inside > before;
  }
  bool yield_to(int mesh, const Placement& previous, const Placement& current) noexcept;
  void run(ProxyStep& result) noexcept;

 private:
  const dvec3& local(std::uint32_t point) const noexcept { return near_.local(point); }
  /// If the whole motion to the hand is far from matter, moves to the hand and returns true.
  bool fly() noexcept;
  /// Finds the points near matter at the current pose.
  void find_near() noexcept {
    near_.collect(tool_, std::min(need(), k_first_margin * near_.margin_unit_mm()));
    is_found_ = true;
    state_.balls_inside = near_.is_complete() ? near_.inside_count() : k_unknown_count;
  }
  /// Returns an upper bound of the motion of any point on the way to the hand, mm.
  double need() const noexcept { return 1.001 * near_.size_of(twist_between(tool_, hand_)); }
  void find_bounds() noexcept;
  void add_bound(std::size_t near) noexcept;
  bool has_bound(std::size_t near) const noexcept;
  /// Returns the largest distance by which a wall moved the tool back to its gap in the last round, mm.
  double rise() const noexcept {
    double most = 0;
    for (std::size_t k = 0; k < bound_count_; ++k)
      if (bounds_[k].push > 0) most = std::max(most, bounds_[k].least);
    return most;
  }
  bool add_stops(bool was_stopped) noexcept;
  void keep_slips() noexcept;
  Twist solve(const Twist& request) noexcept;
  double update_friction(Twist t) noexcept;
  /// Changes a motion by a push at `arm`.
  void add_push(Twist& t, const dvec3& direction, const dvec3& arm, double size) const noexcept {
    t.translation += size * direction;
    t.rotation += (size / square_) * glm::cross(arm, direction);
  }
  double advance(const Twist& t) noexcept;
  void report(ProxyStep& result, double share) const noexcept;

  const TouchScene& scene_;
  const PointShell& shell_;
  SceneWalls& walls_;
  ProxyState& state_;
  ProxyCounters& counters_;
  double square_, voxel_;
  Placement hand_, tool_;
  std::size_t bound_count_ = 0, previous_count_ = 0;
  bool is_found_ = false;     ///< near_ is valid for tool_ and the current placements of models
  bool has_slipped_ = false;  ///< the friction was exceeded in a round of this step
  struct Slip {
    std::uint32_t point;
    int shape;
    double size[2];
  };
  static constexpr std::size_t k_most_bounds = k_max_bounds + k_rounds;
  std::array<Slip, k_most_bounds> previous_;  ///< friction of the previous round
  std::array<Bound, k_most_bounds> bounds_;
  std::array<std::size_t, k_rounds> stops_;  ///< points that stopped earlier motions; indices in near_
  std::size_t stop_count_ = 0;
  /// A wall that may become a bound.
  struct Candidate {
    std::size_t near;
    double room, square;  ///< mm, to the wall; mm2, squared difference from the most similar bound
    dvec3 position, normal;
  };
  std::array<Candidate, NearPoints::k_max> candidates_;
  SmoothWalls::LargeCache cache_;
  NearPoints near_;
};

bool Shell::fly() noexcept {
  if (!near_.is_free_within(tool_, need())) return false;
  tool_ = hand_;
  state_.balls_inside = 0;
  state_.is_sticking = false;
  return true;
}

void Shell::add_bound(std::size_t n) noexcept {
  const Near& near = near_[n];
  const dvec3 normal = near_.normal_of(near);
  if (normal == dvec3(0) || !near.has_wall) return;
  Bound& b = bounds_[bound_count_++];
  b.normal = normal;
  b.room = near_.room_of(near);
  b.arm = tool_.rotation * local(near.point);
  b.moment = glm::cross(b.arm, b.normal);
  b.least = std::min(k_gap * voxel_ - b.room, 0.1 * voxel_);
  b.near = n;
  const Material& material = material_of(scene_, near.wall.shape, side_of(near.wall.is_back));
  b.friction =
      state_.is_sticking || !state_.had_contact ? material.static_friction : material.dynamic_friction;
  const dvec3 size = glm::abs(b.normal);
  const dvec3 other = size.x < size.y && size.x < size.z ? dvec3(1, 0, 0)
                      : size.y < size.z                  ? dvec3(0, 1, 0)
                                                         : dvec3(0, 0, 1);
  b.tangents[0] = glm::normalize(glm::cross(b.normal, other));
  b.tangents[1] = glm::cross(b.normal, b.tangents[0]);
  b.slip[0] = b.slip[1] = 0;
  for (std::size_t k = 0; k < previous_count_; ++k)
    if (const Slip& old = previous_[k]; old.point == near.point && old.shape == near.shape)
      b.slip[0] = old.size[0], b.slip[1] = old.size[1];
}

/// Finds the walls that bound the motion. The first is the nearest wall; each further wall is the one that
/// differs most, in position and normal, from all chosen before. A few different walls hold a tool as well as
/// many similar ones, and the solver requires fewer sweeps.
void Shell::find_bounds() noexcept {
  bound_count_ = 0;
  std::size_t count = 0;
  near_.update_walls();
  for (std::size_t k = 0; k < near_.size(); ++k)
    if (const double room = near_.room_of(near_[k]); room < near_.margin())
      candidates_[count++] = {k, room, 1e300, local(near_[k].point), near_.normal_of(near_[k])};
  if (count == 0) return;
  const auto first =
      std::min_element(candidates_.begin(), candidates_.begin() + static_cast<std::ptrdiff_t>(count),
                       [](const Candidate& a, const Candidate& b) { return a.room < b.room; });
  const double normal_weight = k_normals_apart * voxel_ * (k_normals_apart * voxel_);
  for (std::size_t next = static_cast<std::size_t>(first - candidates_.begin());
       bound_count_ < k_max_bounds;) {
    const Candidate chosen = candidates_[next];
    add_bound(chosen.near);
    std::size_t farthest = 0;
    for (std::size_t k = 0; k < count; ++k) {
      Candidate& c = candidates_[k];
      const dvec3 off = c.position - chosen.position, bent = c.normal - chosen.normal;
      c.square = std::min(c.square, glm::dot(off, off) + normal_weight * glm::dot(bent, bent));
      if (c.square > candidates_[farthest].square) farthest = k;
    }
    if (!(candidates_[farthest].square > 0)) break;
    next = farthest;
  }
}

bool Shell::has_bound(std::size_t near) const noexcept {
  return std::any_of(bounds_.begin(), bounds_.begin() + static_cast<std::ptrdiff_t>(bound_count_),
                     [&](const Bound& b) { return b.near == near; });
}

/// Adds the walls that stopped the motions of earlier rounds. Without them, a long tool that stopped at one
/// end would next be stopped at its other end, and so on. Returns true if the last motion, which
/// `was_stopped`, was stopped at a point that stopped none before.
bool Shell::add_stops(bool was_stopped) noexcept {
  bool is_new = false;
  if (was_stopped && near_.is_stopped()) {
    near_.use_stopping_wall();
    const auto end = stops_.begin() + static_cast<std::ptrdiff_t>(stop_count_);
    is_new = std::find(stops_.begin(), end, near_.stopped()) == end;
    if (is_new) stops_[stop_count_++] = near_.stopped();
  }
  for (std::size_t i = 0; i < stop_count_; ++i)
    if (!has_bound(stops_[i])) add_bound(stops_[i]);
  return is_new;
}

/// Stores the friction for the next round, and sets has_slipped_ if it was exceeded.
void Shell::keep_slips() noexcept {
  previous_count_ = bound_count_;
  double slips = 0, limits = 0;
  for (std::size_t k = 0; k < bound_count_; ++k) {
    const Bound& b = bounds_[k];
    slips += std::sqrt(b.slip[0] * b.slip[0] + b.slip[1] * b.slip[1]);
    limits += b.friction * b.push;
    previous_[k] = {near_[b.near].point, near_[b.near].shape, {b.slip[0], b.slip[1]}};
  }
  has_slipped_ = has_slipped_ || !(slips < 0.999 * limits);
}

/// Returns the motion within the bounds that is nearest to the request, with friction: a part of each wall's
/// friction is found by Gauss-Seidel sweeps for given pushes, and the pushes are found exactly for given
/// friction, in turns. The motion always satisfies the bounds, even where the friction has not converged.
Twist Shell::solve(const Twist& request) noexcept {
  const double inverse_square = 1 / square_;
  std::array<MotionBound, k_most_bounds> walls;
  std::copy_n(bounds_.begin(), bound_count_, walls.begin());
  double change = 1e300;
  for (int turn = 0;; ++turn) {
    Twist t = request;
    for (std::size_t k = 0; k < bound_count_; ++k)
      for (int i = 0; i < 2; ++i) add_push(t, bounds_[k].tangents[i], bounds_[k].arm, bounds_[k].slip[i]);
    find_pushes(t, square_, std::span(walls).first(bound_count_));
    for (std::size_t k = 0; k < bound_count_; ++k) {
      Bound& b = bounds_[k];
      b.push = walls[k].push;
      t.translation += b.push * b.normal;
      t.rotation += (b.push * inverse_square) * b.moment;
    }
    if (turn == k_friction_turns || change < k_least_change * voxel_) return t;
    change = update_friction(t);
  }
}

/// Updates the friction for the current pushes. Returns the largest change, mm.
double Shell::update_friction(Twist t) noexcept {
  double most = 0;
  for (int sweep = 0; sweep < k_sweeps; ++sweep) {
    double largest_change = 0;
    for (std::size_t k = 0; k < bound_count_; ++k) {
      Bound& b = bounds_[k];
      const double limit = b.friction * b.push;
      if (limit == 0 && b.slip[0] == 0 && b.slip[1] == 0) continue;
      double slip[2];
      for (int i = 0; i < 2; ++i) {
        const dvec3 moment = glm::cross(b.arm, b.tangents[i]);
        const double moved = glm::dot(b.tangents[i], t.translation) + glm::dot(moment, t.rotation);
        slip[i] = b.slip[i] - moved / (1 + glm::dot(moment, moment) / square_);
      }
      const double size = std::sqrt(slip[0] * slip[0] + slip[1] * slip[1]);
      const double scale = size > limit ? limit / size : 1;
      for (int i = 0; i < 2; ++i) {
        const double change = scale * slip[i] - b.slip[i];
        largest_change = std::max(largest_change, std::abs(change));
        add_push(t, b.tangents[i], b.arm, change);
        b.slip[i] = scale * slip[i];
      }
    }
    most = std::max(most, largest_change);
    if (largest_change < k_least_change * voxel_) break;
  }
  return most;
}

/// Moves along `t` as far as the motion of every point is proven free. Returns that share of `t`.
double Shell::advance(const Twist& t) noexcept {
  near_.forget_stop();
  const double size = near_.size_of(t);
  double share = size > near_.margin() ? near_.margin() / size : 1;
  // A shortened motion takes other paths, which must be proven free again.
  for (int again = 0; again < 4; ++again) {
    const Placement to = moved(tool_, share * t);
    const double free = near_.free_share(to, again < 3 ? k_max_searches : k_last_try_searches);
    if (free == 1) {
      tool_ = to;
      near_.move_to(to, share * size);
      return share;
    }
    share *= free;
    if (!(share > 0)) break;
  }
  return 0;
}

void Shell::run(ProxyStep& result) noexcept {
  if (fly()) return;
  if (!is_found_) find_near();
  double share = 1, rest = 0;  // mm, length of the part of the last motion that was not made
  int collections = 1;
  Placement best = tool_;
  double last = length_of_springs(tool_, hand_, square_), least = last - k_min_gain * voxel_;
  for (int round = 0; round < k_rounds; ++round) {
    ++result.counters.iterations;
    if (!(near_.margin() > k_min_motion * voxel_)) {
      if (collections++ == k_max_collections) break;
      const double unit = near_.margin_unit_mm();
      near_.collect(
          tool_, std::min(need(), std::clamp(k_spare * rest, k_first_margin * unit, k_next_margin * unit)));
      stop_count_ = 0;
    }
    find_bounds();
    const bool has_new_stop = add_stops(share < 1);
    Twist t = solve(twist_between(tool_, hand_));
    keep_slips();
    const double turn = glm::length(t.rotation);
    const bool is_whole = turn <= k_longest_turn;
    if (!is_whole) t = (k_longest_turn / turn) * t;
    if (!(near_.size_of(t) > k_min_motion * voxel_)) break;
    const bool was_stuck = share == 0;
    share = advance(t);
    rest = (1 - share) * near_.size_of(t);
    const double length = length_of_springs(tool_, hand_, square_),
                 gain = std::exchange(last, length) - length;
    if (length - rise() < least) best = tool_, least = length;
    if (share == 1 && gain < k_slow * voxel_) break;  // the next step continues the motion
    if ((share == 0 && was_stuck && !has_new_stop) || (share == 1 && is_whole && bound_count_ == 0)) break;
  }
  tool_ = best;
  result.turn_world = turn_between(hand_.rotation, tool_.rotation);
  report(result, share);
}

/// Reports the walls that pushed in the last round.
void Shell::report(ProxyStep& result, double share) const noexcept {
  const Bound* hardest = nullptr;
  dvec3 sum(0);
  for (std::size_t k = 0; k < bound_count_; ++k) {
    const Bound& b = bounds_[k];
    if (!(b.push > 0)) continue;
    sum += b.push * b.normal;
    if (hardest == nullptr || b.push > hardest->push) hardest = &b;
    result.contacts.add({tool_.position_world + b.arm, b.normal, b.push, near_[b.near].wall.shape,
                         side_of(near_[b.near].wall.is_back)});
  }
  state_.is_sticking = hardest != nullptr && !has_slipped_;
  const dvec3 back = tool_.position_world - hand_.position_world;
  if (back == dvec3(0) && result.turn_world == dvec3(0)) return;
  if (hardest == nullptr) {
    if (share < 1 && near_.is_stopped() && back != dvec3(0))
      result.set_contact(near_.stopping_wall().shape, side_of(near_.stopping_wall().is_back),
                         glm::normalize(back));
    return;
  }
  const double length = glm::length(sum);
  const Wall& wall = near_[hardest->near].wall;
  result.set_contact(wall.shape, side_of(wall.is_back),
                     length > 1e-3 * hardest->push ? sum / length : hardest->normal);
}

/// Handles the motion of a mesh since the previous step. Returns false if the mesh passed over the tool.
bool Shell::yield_to(int mesh, const Placement& previous, const Placement& current) noexcept {
  is_found_ = false;
  const MeshMotion motion(walls_, mesh, previous, current, voxel_);
  const auto find_push = [&](const Placement& to, dvec3& push) {
    bool is_any = false;
    double first = 2;
    // Relative to the mesh, the tool also rotates about the straight path of a sphere's centre. `wider`
    // enlarges the spheres, so that they contain the rotated points.
    const dquat turn =
        glm::conjugate(current.rotation) * to.rotation * glm::conjugate(tool_.rotation) * previous.rotation;
    const double wider = 1 + glm::length(turn_between({1, 0, 0, 0}, turn));
    shell_.visit(
        [&](const PointShell::Node& node) {
          const dvec3 a = previous.local_from_world(tool_.world_from_local(node.centre)),
                      b = current.local_from_world(to.world_from_local(node.centre));
          return !motion.tree.is_near(0.5 * (a + b), 0.5 * glm::length(b - a) + node.radius * wider);
        },
        [&](std::uint32_t i) {
          is_any = motion.meets(tool_, to, local(i), 0, first, push, counters_.triangles) || is_any;
          return true;
        });
    return is_any;
  };
  const auto try_pose = [&](const Placement& to) {
    if (!near_.is_motion_free(tool_, to, mesh)) return false;
    tool_ = to;
    return true;
  };
  return motion.move(tool_, find_push, try_pose);
}

}  // namespace

Status ShellProxy::prepare(const TouchScene& scene) {
  if (Status error = check_offsets(scene, info())) return error;
  for (const TouchItem& item : scene.items)
    if (!item.is_mesh() && blocks(item.sides, Side::back))
      return Error{.what = "contact from inside needs a point",
                   .where = item.field.shape().name,
                   .found = "its back is touchable",
                   .expected = "shapes touched from the front",
                   .remedy = "use a point, or touch the outside only"};
  auto layout = SceneLayout::of(scene);
  if (!layout) return layout.error();
  layout_ = std::move(layout).value();
  return std::nullopt;
}

ProxyStep ShellProxy::step(const TouchScene& scene, const TouchState& touch_state, ProxyState& state,
                           const ProxyInput& input) const noexcept {
  return step_rigid_tool<Shell>(layout_, scene, touch_state, state, input);
}

}  // namespace trephine::haptics
