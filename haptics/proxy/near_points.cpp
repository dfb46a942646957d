#include "haptics/proxy/near_points.h"

#include <algorithm>
#include <cmath>

namespace trephine::haptics {

using glm::dmat3;
using glm::dvec3;

namespace {

// In voxels of the scene's frame (SceneLayout::frame()).
constexpr double k_least_gap = 5e-4;  // least distance at the end of a motion that a wall stops
constexpr double k_landing = 1e-3;    // largest distance from a wall at the end of a searched motion
// Largest number of samples in a unit of margins. The largest margin of a shell is 0.45 units, less than one
// sample. A box of this margin around a point thus meets at most 3 x 3 x 3 cubes.
constexpr double k_samples_per_margin_unit = 2.2;
constexpr double k_least_margin = 0.1;  // units of margins; instead of a smaller margin, points are left out
constexpr int k_most_cubes = 27;        // in the box around a point and its margin
constexpr std::uint32_t k_group = 64;   // points of a node for which the facets nearby are found together
constexpr double k_shorter = 0.3;  // share of a motion that is tried next if it requires too many searches

}  // namespace

NearPoints::NearPoints(const TouchScene& scene, SceneWalls& walls, ProxyCounters& counters) noexcept
    : shell_(*scene.tool->shell()),
      walls_(walls),
      counters_(counters),
      voxel_(walls.frame().spacing().x),
      margin_unit_(std::min(voxel_, k_samples_per_margin_unit * walls.sample_mm())) {}

/// Returns true if no shape but `skipped` is within `mm` of p.
bool NearPoints::is_free_within(const dvec3& p, double mm, int skipped) noexcept {
  for (int s = walls_.next_shape(0); s < ShapeSet::k_max; s = walls_.next_shape(s + 1))
    if (s != skipped && !walls_.is_free_within(s, p, mm)) return false;
  return true;
}

ShapeSet NearPoints::solids_at(const dvec3& p) noexcept {
  ShapeSet solids;
  for (int s = walls_.next_shape(0); s < ShapeSet::k_max; s = walls_.next_shape(s + 1))
    if (walls_.is_solid(s, p)) solids.set(s, true);
  return solids;
}

bool NearPoints::is_motion_free(const Placement& tool, const Placement& to, int skipped) noexcept {
  const double mm = 1.001 * size_of(twist_between(tool, to));
  const dmat3 before = glm::mat3_cast(tool.rotation), after = glm::mat3_cast(to.rotation);
  bool is_free = true;
  shell_.visit(
      [&](const PointShell::Node& node) {
        return is_free_within(in_scene(tool, before, node.centre), node.radius + mm, skipped);
      },
      [&](std::uint32_t i) {
        const dvec3 a = in_scene(tool, before, local(i)), b = in_scene(to, after, local(i));
        ShapeSet inside = solids_at(a);
        is_free = !walls_.reach(a, b, inside, k_landing * voxel_, skipped).is_blocked;
        return is_free;
      });
  return is_free;
}

/// Collects the points that could meet matter while they move by at most `mm`, except the points that bounds
/// on their walls prove free. Returns false if there are too many.
bool NearPoints::collect_within(const Placement& tool, double mm) noexcept {
  count_ = 0;
  forget_stop();
  margin_ = mm;
  inside_count_ = 0;
  const dmat3 rotation = glm::mat3_cast(tool.rotation);
  bool is_full = false;
  std::uint32_t group_end = 0;
  // Returns true if a point is farther than the margin from a shape near the current leaf.
  const auto is_far_from = [&](int s, const dvec3& p) {
    if (!walls_.is_mesh(s)) return walls_.is_free_within(s, p, mm);
    const std::span<const MeshTree::Facet> facets = around_leaf_.facets_of(s);
    if (!facets.data()) return false;
    const dvec3 at = walls_.in_mesh(s, p);
    return std::none_of(facets.begin(), facets.end(),
                        [&](const MeshTree::Facet& facet) { return facet.may_be_within(at, mm); });
  };
  shell_.visit(
      [&](const PointShell::Node& node) {
        ++counters_.cells;
        const dvec3 centre = in_scene(tool, rotation, node.centre);
        const double reach = node.radius + mm;
        if (node.end - node.begin > k_group) return is_free_within(centre, reach);
        if (node.begin >= group_end) {
          group_end = node.end;
          if (!around_group_.find(walls_, centre, reach, nullptr)) return true;
        }
        return !around_leaf_.find(walls_, centre, reach, &around_group_);
      },
      [&](std::uint32_t i) {
        if (i % stride_ != 0) return true;
        ++counters_.voxels;
        const dvec3 p = in_scene(tool, rotation, local(i));
        const ShapeSet& shapes = around_leaf_.shapes;
        for (int s = shapes.next(0); s < ShapeSet::k_max && !is_full; s = shapes.next(s + 1))
          is_full = !is_far_from(s, p) && !add(i, s, p);
        return !is_full;
      });
  return !is_full;
}

/// Finds the shapes of `among` within `mm` of p, and the facets of meshes there. Returns false if there are
/// none.
bool NearPoints::NearShapes::find(SceneWalls& walls, const dvec3& p, double mm,
                                  const NearShapes* among) noexcept {
  shapes = ShapeSet{};
  mesh_count = 0;
  std::size_t used = 0;
  const auto next = [&](int s) { return among ? among->shapes.next(s) : walls.next_shape(s); };
  for (int s = next(0); s < ShapeSet::k_max; s = next(s + 1)) {
    const std::span<MeshTree::Facet> rest = std::span(facets).subspan(used);
    if (!walls.is_mesh(s) || rest.empty() || mesh_count == meshes.size()) {
      shapes.set(s, !walls.is_free_within(s, p, mm));
      continue;
    }
    const std::size_t found =
        walls.find_facets(s, p, mm, rest, among ? among->facets_of(s) : std::span<const MeshTree::Facet>());
    if (found == 0) continue;
    shapes.set(s, true);
    if (found > rest.size()) continue;  // the tree of the mesh is searched for each point
    meshes[mesh_count++] = {s, rest.first(found)};
    used += found;
  }
  return !shapes.is_empty();
}

/// Adds a point unless it is proven free within the margin. Returns false if there are too many.
bool NearPoints::add(std::uint32_t point, int shape, const dvec3& at) noexcept {
  if (count_ == all_.size()) return false;
  Near& near = all_[count_];
  near.point = point;
  near.shape = shape;
  near.at = at;
  near.is_inside = false;
  look_up(near, around_leaf_.facets_of(shape));
  if (near.has_bound && !near.has_wall) return true;  // no facet within the margin
  if (!walls_.is_mesh(shape)) near.is_inside = near.has_wall ? near.value >= 0 : walls_.is_solid(shape, at);
  if (!near.is_inside && near.has_one_wall) {
    const dvec3 reach(margin_ / voxel_);
    near.hessian = walls_.hessian_bound_around(near.wall, at, reach.x, near.has_bound, k_most_cubes);
    // The largest value within the margin.
    const double highest = near.value + glm::length(near.gradient) * reach.x +
                           0.5 * near.hessian.along(reach) +
                           rounding_of({near.value, near.gradient}, near.hessian);
    if (near.has_bound && highest < 0) return true;
  }
  inside_count_ += near.is_inside;
  ++count_;
  return true;
}

void NearPoints::collect(const Placement& tool, double mm) noexcept {
  stride_ = 1;
  while (!collect_within(tool, mm))
    if (mm > k_least_margin * margin_unit_)
      mm = std::max(0.5 * mm, k_least_margin * margin_unit_);
    else
      stride_ *= 2;
}

bool NearPoints::is_free_within(const Placement& tool, double mm) noexcept {
  const dvec3 p = in_scene(tool, glm::mat3_cast(tool.rotation), shell_.root().centre);
  if (!is_free_within(p, shell_.root().radius + mm)) return false;
  count_ = 0;
  forget_stop();
  inside_count_ = 0;
  return true;
}

void NearPoints::set_wall(Near& near, const Wall& wall) noexcept {
  const volume::ValueAndGradient field = walls_.value_and_gradient(wall, near.at);
  near.wall = wall;
  near.value = field.value;
  near.gradient = field.gradient;
  near.origin = near.at;
}

/// Finds the shape's wall that is nearest to the point. `facets`: all facets of a mesh within the margin, or
/// nothing.
void NearPoints::look_up(Near& near, std::span<const MeshTree::Facet> facets) noexcept {
  SceneWalls::WallList few;
  SceneWalls::NearFacets near_facets{.candidates = facets};
  const int count = walls_.walls_at(near.shape, {}, near.at, margin_, few, &near_facets);
  const bool is_complete = near_facets.is_complete;
  near.has_wall = count > 0;
  near.has_one_wall = count == 1 && !walls_.is_mesh(near.shape);
  near.has_bound = is_complete;
  near.hessian = {dvec3(0), dvec3(0)};
  near.facet_count = 0;
  near.value = -1e300;
  near.origin = near.at;
  near.gradient = dvec3(0);
  double least = 1e300;
  int nearest = 0;
  for (int k = 0; k < count; ++k) {
    set_wall(near, few[static_cast<std::size_t>(k)]);
    const double room = room_of(near);
    if (k > 0 && !(room < least)) continue;
    least = room;
    nearest = k;
  }
  if (count > 1) set_wall(near, few[static_cast<std::size_t>(nearest)]);
  for (int k = 0; k < count && is_complete; ++k)
    if (const Wall& wall = few[static_cast<std::size_t>(k)]; k != nearest)
      near.facets[near.facet_count++] = {wall.facet, wall.is_back};
}

/// Makes a further facet the wall of the point, and its wall a further facet.
void NearPoints::exchange_wall(Near& near, std::size_t facet) noexcept {
  const Near::Facet old{near.wall.facet, near.wall.is_back};
  set_wall(near, {near.shape, false, near.facets[facet].is_back, near.facets[facet].triangle});
  near.facets[facet] = old;
}

/// Returns true if the facets of a mesh bound the motion of the point, and the point stays in front of their
/// planes on the way to `to`.
bool NearPoints::is_before_facets(const Near& near, const dvec3& to) noexcept {
  if (!near.has_bound) return false;
  const auto is_before = [&](const volume::ValueAndGradient& facet, const dvec3& origin) {
    const double highest = facet.value + std::max(glm::dot(facet.gradient, near.at - origin),
                                                  glm::dot(facet.gradient, to - origin));
    return highest + rounding_of(facet, near.hessian) < -k_least_gap * glm::length(facet.gradient);
  };
  if (near.has_wall && !is_before({near.value, near.gradient}, near.origin)) return false;
  for (std::size_t k = 0; k < near.facet_count; ++k) {
    const Near::Facet& facet = near.facets[k];
    if (!is_before(walls_.value_and_gradient({near.shape, false, facet.is_back, facet.triangle}, near.at),
                   near.at))
      return false;
  }
  return true;
}

/// Makes the nearest of the facets that bound the motion the wall of the point. Returns false if the point
/// may meet other facets.
bool NearPoints::use_nearest_facet(Near& near) noexcept {
  if (!is_before_facets(near, near.at)) return false;
  double least = room_of(near);
  for (std::size_t k = 0; k < near.facet_count; ++k) {
    exchange_wall(near, k);
    if (const double room = room_of(near); room < least)
      least = room;
    else
      exchange_wall(near, k);
  }
  return true;
}

double NearPoints::room_of(const Near& near) const noexcept {
  if (near.is_inside || !near.has_wall) return 1e300;
  const double steepness = glm::length(near.gradient) / voxel_;
  const double value = near.value + glm::dot(near.gradient, near.at - near.origin);
  return steepness > 0 ? -value / steepness : 1e300;
}

/// Returns the share of the straight motion of a point that bounds on its wall prove free. A share below 1 is
/// a little less than the free share, so that the point keeps a gap to the wall. Empty if the bounds prove
/// nothing and a search is required.
std::optional<double> NearPoints::proven_share(Near& near, const dvec3& to) noexcept {
  if (near.has_bound) {
    const double rounding = rounding_of({near.value, near.gradient}, near.hessian);
    if (near.highest(near.at, to) + rounding < -k_least_gap * glm::length(near.gradient)) return 1.0;
    if (near.at != near.origin) set_wall(near, near.wall);
    const dvec3 along = to - near.at;
    const double value = near.value + rounding, slope = glm::dot(near.gradient, along),
                 bend = near.hessian.along(along), gap = -k_least_gap * glm::length(near.gradient);
    if (value < gap) return std::min(1.0, free_step(value - gap, slope, bend));
    if (value < 0) return slope >= 0 ? 0 : bend > 0 ? std::min(1.0, -2 * slope / bend) : 1;
  }
  if (walls_.is_free_within(near.shape, near.at, glm::length(to - near.at) * voxel_)) return 1.0;
  return std::nullopt;
}

double NearPoints::free_share(const Placement& to, int max_searches) noexcept {
  double least = 1;
  int searches = 0;
  const dmat3 rotation = glm::mat3_cast(to.rotation);
  for (std::size_t k = 0; k < count_; ++k) {
    Near& near = all_[k];
    if (near.is_inside) continue;
    const dvec3 end = in_scene(to, rotation, local(near.point));
    if (end == near.at) continue;
    const bool is_mesh = walls_.is_mesh(near.shape);
    if (is_mesh && is_before_facets(near, end)) continue;
    if (const std::optional<double> proven = is_mesh ? std::nullopt : proven_share(near, end)) {
      if (*proven < least) least = *proven, stopped_ = k, stopping_wall_ = near.wall;
      continue;
    }
    Reach reach;
    if (is_mesh) {
      reach = walls_.reach_model(near.shape, near.at, end, k_landing * voxel_, least);
    } else {
      if (++searches > max_searches) return std::min(least, k_shorter);
      ShapeSet inside = inside_count_ > 0 ? solids_at(near.at) : ShapeSet{};
      reach = walls_.reach(near.at, end, inside, k_landing * voxel_, -1, least);
    }
    if (!reach.is_blocked || !(reach.t < least)) continue;
    least = reach.t;
    stopped_ = k;
    stopping_wall_ = reach.wall;
  }
  return least;
}

void NearPoints::move_to(const Placement& tool, double mm) noexcept {
  margin_ = std::max(0.0, margin_ - mm);
  const dmat3 rotation = glm::mat3_cast(tool.rotation);
  for (std::size_t k = 0; k < count_; ++k) all_[k].at = in_scene(tool, rotation, local(all_[k].point));
}

void NearPoints::update_walls() noexcept {
  for (std::size_t k = 0; k < count_; ++k) {
    Near& near = all_[k];
    if (near.is_inside || !near.has_wall || near.at == near.origin || !(room_of(near) < 1.5 * margin_))
      continue;
    if (walls_.is_mesh(near.shape) && use_nearest_facet(near)) continue;
    const Wall before = near.wall;
    const auto hessian = near.hessian;
    const bool had_bound = near.has_bound;
    look_up(near);
    if (had_bound && near.has_one_wall && near.wall == before) near.has_bound = true, near.hessian = hessian;
  }
}

void NearPoints::use_stopping_wall() noexcept {
  Near& near = all_[stopped_];
  if (near.wall == stopping_wall_ && near.origin == near.at) return;
  if (walls_.is_mesh(near.shape) && near.has_bound) {
    if (near.wall == stopping_wall_) return;
    for (std::size_t k = 0; k < near.facet_count; ++k)
      if (near.facets[k].triangle == stopping_wall_.facet && near.facets[k].is_back == stopping_wall_.is_back)
        return exchange_wall(near, k);
  }
  set_wall(near, stopping_wall_);
  near.has_wall = true;
  near.has_one_wall = near.has_bound = false;  // a search also tests the other walls
}

dvec3 NearPoints::normal_of(const Near& near) const noexcept {
  const dvec3 gradient = walls_.frame().gradient_world_from_volume(near.gradient);
  const double steepness = glm::length(gradient);
  return steepness > 0 ? (-1 / steepness) * gradient : dvec3(0);
}

}  // namespace trephine::haptics
