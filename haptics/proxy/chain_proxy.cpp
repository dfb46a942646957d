#include "haptics/proxy/chain_proxy.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <utility>

#include "haptics/proxy/nearest_motion.h"
#include "haptics/proxy/rigid_step.h"

namespace trephine::haptics {

using glm::dquat;
using glm::dvec3;

namespace {

// In voxels of the scene's frame (SceneLayout::frame()), unless another unit is given.
constexpr double k_gap = 2e-3;            // distance that balls keep from walls
constexpr double k_landing = 1e-3;        // largest distance from a wall at the end of a free motion
constexpr double k_bound_distance = 0.4;  // nearer walls bound a motion
constexpr double k_min_gain = 1e-4;       // a motion counts if it reduces the distance to the hand by more
constexpr double k_min_motion = 1e-5;     // a smaller motion ends the rounds
constexpr double k_longest_turn = 0.1;    // rad per round
constexpr int k_rounds = 8;
constexpr std::size_t k_max_walls = 48;

/// Wall near a ball that bounds a motion.
struct NearWall {
  std::size_t ball;
  Wall wall;
};

/// One step of a tool of several balls.
class Chain {
 public:
  Chain(const TouchScene& scene, SceneWalls& walls, ProxyState& state, const ProxyInput& input,
        ProxyCounters& counters) noexcept
      : shape_(*scene.tool),
        balls_(scene.tool->balls()),
        walls_(walls),
        state_(state),
        counters_(counters),
        square_(scene.tool->gyration_square()),
        voxel_(walls.frame().spacing().x),
        hand_{input.hip_world, unit_of(input.orientation)} {}

  /// Starts at the hand, even inside a solid.
  void begin(const volume::Frame& base) noexcept {
    state_.begin_at(base.volume_from_world(hand_.position_world));
    tool_ = hand_;
    update_balls_inside();
  }
  /// Updates the balls that are in a solid. Returns true if matter grew over a ball.
  bool update_balls_inside() noexcept {
    const std::uint32_t before = state_.balls_inside;
    state_.balls_inside = 0;
    for (std::size_t i = 0; i < balls_.size(); ++i)
      if (!solids_at(ball(tool_, i)).is_empty()) state_.balls_inside |= 1u << i;
    return (state_.balls_inside & ~before) != 0;
  }
  void resume(const Placement& tool) noexcept { tool_ = tool; }
  bool has_grown() noexcept { return update_balls_inside(); }
  /// Handles the motion of a mesh since the previous step. Returns false if the mesh passed over the tool.
  bool yield_to(int mesh, const Placement& previous, const Placement& current) noexcept;
  const Placement& pose() const noexcept { return tool_; }
  const Placement& hand() const noexcept { return hand_; }
  void run(ProxyStep& result) noexcept;

 private:
  dvec3 ball(const Placement& tool, std::size_t i) const noexcept {
    return walls_.frame().volume_from_world(tool.world_from_local(balls_[i].centre));
  }
  ShapeSet solids_at(const dvec3& p) noexcept {
    ShapeSet found;
    for (int s = walls_.next_shape(0); s < ShapeSet::k_max; s = walls_.next_shape(s + 1))
      if (walls_.is_solid(s, p)) found.flip(s);
    return found;
  }
  double length_of_springs() const noexcept { return haptics::length_of_springs(tool_, hand_, square_); }
  void find_bounds() noexcept;
  void add_bound(const Wall& wall, std::size_t ball, const dvec3& p) noexcept;
  Twist solve(const Twist& request) noexcept;
  double free_share(const Placement& to, Wall& wall, std::size_t& stopped_ball, int skipped = -1) noexcept;
  double advance(const Twist& t, Wall& wall, std::size_t& stopped_ball) noexcept;
  void update_inside_flags() noexcept;

  const ToolShape& shape_;
  std::span<const ToolShape::Ball> balls_;
  SceneWalls& walls_;
  ProxyState& state_;
  ProxyCounters& counters_;
  double square_, voxel_;
  Placement hand_, tool_;
  std::array<MotionBound, k_max_walls> bounds_;
  std::array<NearWall, k_max_walls> near_walls_;  ///< of the bounds
  std::size_t count_ = 0;
};

void Chain::add_bound(const Wall& wall, std::size_t i, const dvec3& p) noexcept {
  if (count_ == k_max_walls) return;
  const volume::ValueAndGradient field = walls_.value_and_gradient(wall, p);
  const dvec3 gradient = walls_.frame().gradient_world_from_volume(field.gradient);
  const double steepness = glm::length(gradient);
  if (!(steepness > 0)) return;
  const dvec3 away = (-1 / steepness) * gradient;
  const double room = -field.value / steepness;
  if (!(room < k_bound_distance * voxel_)) return;
  const dvec3 arm = tool_.rotation * balls_[i].centre;
  bounds_[count_] = {away, glm::cross(arm, away), std::min(k_gap * voxel_ - room, 0.1 * voxel_)};
  near_walls_[count_++] = {i, wall};
}

/// Finds the walls near the balls at the current pose.
void Chain::find_bounds() noexcept {
  count_ = 0;
  for (std::size_t i = 0; i < balls_.size(); ++i) {
    const dvec3 p = ball(tool_, i);
    const ShapeSet inside = state_.balls_inside >> i & 1 ? solids_at(p) : ShapeSet{};
    for (int s = walls_.next_shape(0); s < ShapeSet::k_max; s = walls_.next_shape(s + 1)) {
      if (!walls_.may_block(s, inside.contains(s))) continue;
      SceneWalls::WallList walls;
      const int found = walls_.walls_at(s, inside, p, k_bound_distance * voxel_, walls);
      for (int k = 0; k < found; ++k) add_bound(walls[static_cast<std::size_t>(k)], i, p);
    }
  }
}

/// Returns the motion within the bounds that is nearest to the request.
Twist Chain::solve(const Twist& request) noexcept {
  const std::span bounds = std::span(bounds_).first(count_);
  find_pushes(request, square_, bounds);
  Twist t = request;
  for (const MotionBound& b : bounds) {
    t.translation += b.push * b.normal;
    t.rotation += (b.push / square_) * b.moment;
  }
  return t;
}

/// Returns the share of the balls' straight motions to their positions in `to` that is free for all balls. If
/// it is less than 1, sets `wall` and `stopped_ball` to the first wall that stops a ball, and to that ball.
/// `skipped`: a shape that is not tested; -1: all are tested.
double Chain::free_share(const Placement& to, Wall& wall, std::size_t& stopped_ball, int skipped) noexcept {
  double least = 1;
  for (std::size_t i = 0; i < balls_.size(); ++i) {
    const dvec3 a = ball(tool_, i), b = ball(to, i);
    if (a == b) continue;
    ShapeSet inside = state_.balls_inside >> i & 1 ? solids_at(a) : ShapeSet{};
    const Reach reach = walls_.reach(a, b, inside, k_landing * voxel_, skipped, least);
    if (reach.is_blocked && reach.t < least) least = reach.t, wall = reach.wall, stopped_ball = i;
  }
  return least;
}

/// Updates the flags of balls that have left a solid, or entered one that does not block.
void Chain::update_inside_flags() noexcept {
  bool may_enter = false;
  for (int s = walls_.next_shape(0); s < ShapeSet::k_max; s = walls_.next_shape(s + 1))
    may_enter = may_enter || (!walls_.is_mesh(s) && !walls_.blocks(s, Side::front));
  for (std::size_t i = 0; i < balls_.size(); ++i) {
    const std::uint32_t bit = 1u << i;
    if ((state_.balls_inside & bit) == 0 && !may_enter) continue;
    state_.balls_inside &= ~bit;
    if (!solids_at(ball(tool_, i)).is_empty()) state_.balls_inside |= bit;
  }
}

/// Moves along `t` as far as every ball's motion is proven free, and returns that share of `t`. If it is less
/// than 1, sets `wall` and `stopped_ball` to the wall that stopped a ball, and to that ball.
double Chain::advance(const Twist& t, Wall& wall, std::size_t& stopped_ball) noexcept {
  double share = 1;
  // A shortened motion takes other paths, which must be proven free again.
  for (int attempt = 0; attempt < 4; ++attempt) {
    const Placement to = moved(tool_, share * t);
    const double free = free_share(to, wall, stopped_ball);
    if (free == 1) {
      tool_ = to;
      return share;
    }
    share *= free;
    if (!(share > 0)) break;
  }
  return 0;
}

bool Chain::yield_to(int mesh, const Placement& previous, const Placement& current) noexcept {
  const MeshMotion motion(walls_, mesh, previous, current, voxel_);
  const auto find_push = [&](const Placement& to, dvec3& push) {
    bool is_any = false;
    double first = 2;
    for (const ToolShape::Ball& ball : balls_)
      is_any = motion.meets(tool_, to, ball.centre, ball.radius, first, push, counters_.triangles) || is_any;
    return is_any;
  };
  const auto try_pose = [&](const Placement& to) {
    Wall wall;
    std::size_t stopped_ball = 0;
    if (free_share(to, wall, stopped_ball, mesh) < 1) return false;
    tool_ = to;
    return true;
  };
  return motion.move(tool_, find_push, try_pose);
}

void Chain::run(ProxyStep& result) noexcept {
  const double farthest = shape_.arm();
  Wall wall;
  std::size_t stopped_ball = 0;
  double share = 1;
  // All poses of the rounds are connected by free motions, so the step may end at any of them. It ends at the
  // pose nearest to the hand. A gain below k_min_gain does not count: otherwise a tool at rest would
  // oscillate between its walls.
  Placement best = tool_;
  double least = length_of_springs() - k_min_gain * voxel_;
  for (int round = 0; round < k_rounds; ++round) {
    ++result.counters.iterations;
    find_bounds();
    if (share < 1) add_bound(wall, stopped_ball, ball(tool_, stopped_ball));
    Twist t = solve(twist_between(tool_, hand_));
    // Limits the rotation, so that balls move nearly straight.
    const double turn = glm::length(t.rotation);
    const bool is_whole = turn <= k_longest_turn;
    if (!is_whole) t = (k_longest_turn / turn) * t;
    if (!(glm::length(t.translation) + farthest * glm::length(t.rotation) > k_min_motion * voxel_)) break;
    const bool was_stuck = share == 0;
    share = advance(t, wall, stopped_ball);
    if (const double length = length_of_springs(); length < least) best = tool_, least = length;
    if ((share == 0 && was_stuck) || (share == 1 && is_whole && count_ == 0)) break;
  }
  tool_ = best;
  update_inside_flags();
  result.turn_world = turn_between(hand_.rotation, tool_.rotation);

  // Reports the walls that pushed in the last round.
  std::size_t hardest = count_;
  dvec3 sum(0);
  for (std::size_t k = 0; k < count_; ++k) {
    const MotionBound& b = bounds_[k];
    if (!(b.push > 0)) continue;
    sum += b.push * b.normal;
    if (hardest == count_ || b.push > bounds_[hardest].push) hardest = k;
    const auto& [ball, wall] = near_walls_[k];
    result.contacts.add({tool_.world_from_local(balls_[ball].centre) - balls_[ball].radius * b.normal,
                         b.normal, b.push, wall.shape, side_of(wall.is_back)});
  }
  const dvec3 back = tool_.position_world - hand_.position_world;
  if (back == dvec3(0) && result.turn_world == dvec3(0)) return;
  if (hardest == count_) {
    // The field is flat at the wall that stopped the tool, so that the wall has no normal. The tool stays,
    // and the direction from the hand back to the tool serves as the normal.
    if (share < 1 && back != dvec3(0))
      result.set_contact(wall.shape, side_of(wall.is_back), glm::normalize(back));
    return;
  }
  const double length = glm::length(sum);
  const Wall& hardest_wall = near_walls_[hardest].wall;
  result.set_contact(hardest_wall.shape, side_of(hardest_wall.is_back),
                     length > 1e-3 * bounds_[hardest].push ? sum / length : bounds_[hardest].normal);
}

}  // namespace

Status ChainProxy::prepare(const TouchScene& scene) {
  if (Status error = check_offsets(scene, info())) return error;
  auto layout = SceneLayout::of(scene);
  if (!layout) return layout.error();
  layout_ = std::move(layout).value();
  return std::nullopt;
}

ProxyStep ChainProxy::step(const TouchScene& scene, const TouchState& touch_state, ProxyState& state,
                           const ProxyInput& input) const noexcept {
  return step_rigid_tool<Chain>(layout_, scene, touch_state, state, input);
}

}  // namespace trephine::haptics
