// One file: all stages of the search for walls share SceneWalls.
#include "haptics/walls/scene_walls.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <new>

#include "haptics/depth/depth_source.h"

namespace trephine::haptics {

using glm::dvec3;
using glm::ivec3;

namespace {

constexpr double k_max_motion = 40;    // mm that an object may move between two sets of depth images
constexpr double k_step = 0.5;         // mm, largest step of the scene's frame without volumes
constexpr double k_steps_across = 40;  // least number of these steps along a model's diagonal
constexpr double k_min_gap = 5e-8;     // steps: half the distance that Slide keeps from walls (k_gap)

/// Returns the box of a shape's voxels in the world, enlarged by two voxels and by the extension of a soft
/// shape into others. low > high: the shape has no matter.
SceneLayout::Box matter_box(const TouchItem& shape) {
  const volume::Volume& base = shape.field.volume();
  const ivec3& size = base.size;
  ivec3 low(1 << 30), high(-1);
  const int words = (size.x + 63) / 64;
  for (int z = 0; z < size.z; ++z)
    for (int y = 0; y < size.y; ++y) {
      const std::uint64_t* row = shape.bits->row(y, z);
      int first = words, last = -1;
      for (int w = 0; w < words; ++w)
        if (row[w]) first = std::min(first, w), last = w;
      if (last < 0) continue;
      low = glm::min(low, ivec3(64 * first + std::countr_zero(row[first]), y, z));
      high = glm::max(high, ivec3(64 * last + 63 - std::countl_zero(row[last]), y, z));
    }
  SceneLayout::Box box{dvec3(1e300), dvec3(-1e300)};
  if (high.x < 0) return box;
  const int margin = 2 + (shape.soft && shape.soft->is_extended() ? volume::SoftField::k_overlap : 0);
  for (int corner = 0; corner < 8; ++corner) {
    const dvec3 p(corner & 1 ? high.x + margin : low.x - margin,
                  corner & 2 ? high.y + margin : low.y - margin,
                  corner & 4 ? high.z + margin : low.z - margin);
    const dvec3 world = base.frame.world_from_volume(p);
    box.low = glm::min(box.low, world);
    box.high = glm::max(box.high, world);
  }
  return box;
}

SceneLayout::Box world_box(const dvec3& low, const dvec3& high, const Placement& placement) {
  SceneLayout::Box box{dvec3(1e300), dvec3(-1e300)};
  if (!(low.x <= high.x)) return box;
  for (int corner = 0; corner < 8; ++corner) {
    const dvec3 p = placement.world_from_local(
        {corner & 1 ? high.x : low.x, corner & 2 ? high.y : low.y, corner & 4 ? high.z : low.z});
    box.low = glm::min(box.low, p);
    box.high = glm::max(box.high, p);
  }
  return box;
}

}  // namespace

namespace {
Error too_many(const char* what, int found, int limit) {
  return {what, "scene", std::to_string(found), "at most " + std::to_string(limit), "touch fewer of them"};
}
}  // namespace

Status SceneLayout::add_voxels(const TouchScene& scene, int index) {
  const TouchItem& shape = item_of(scene, index);
  if (!shape.bits)
    return Error{.what = "a touchable shape has no occupancy",
                 .where = shape.field.shape().name,
                 .remedy = "build it with Occupancy::build()"};
  const volume::Volume& scan = shape.field.volume();
  boxes_.push_back(matter_box(shape));
  if (&scan == scene.base.get() && static_cast<std::size_t>(index) >= base_shapes(scene).size())
    return Error{.what = "the shapes of the base volume must come first",
                 .where = shape.field.shape().name,
                 .remedy = "list them before models and other volumes"};
  const auto has_same_volume = [&](int other) {
    const TouchItem& previous = item_of(scene, other);
    return !previous.is_mesh() && &previous.field.volume() == &scan;
  };
  if (index > 0 && has_same_volume(index - 1)) {
    ++parts_.back().end;
    return std::nullopt;
  }
  for (const Part& part : parts_)
    if (has_same_volume(part.begin))
      return Error{.what = "the shapes of a volume must be adjacent",
                   .where = shape.field.shape().name,
                   .remedy = "list the shapes of one volume one after another"};
  std::shared_ptr<const TouchState> uncut;
  if (&scan != scene.base.get()) {
    for (const auto& other : scene.others)
      if (other.get() == &scan)
        uncut = std::make_shared<TouchState>(std::make_shared<volume::Version>(other));
    if (!uncut)
      return Error{.what = "a shape belongs to an unknown volume",
                   .where = shape.field.shape().name,
                   .remedy = "add the volume to TouchScene::others"};
  }
  const volume::Frame* frame =
      scene.tool->radius() > 0 && shape.offset ? &shape.offset->frame() : &scan.frame;
  parts_.push_back({index, index + 1, uncut, frame, glm::dmat3(1), 0});
  return std::nullopt;
}

Status SceneLayout::add_mesh(const TouchItem& mesh, int index) {
  if (!mesh.tree)
    return Error{.what = "a mesh has no search tree", .where = mesh.name, .remedy = "set TouchItem::tree"};
  if (mesh.depth) {
    if (mesh.mover < 0 && mesh.depth->is_moving(0))
      return Error{
          .what = "a moving item has no mover index", .where = mesh.name, .remedy = "set TouchItem::mover"};
    depth_of_.back() = static_cast<int>(depths_.size());
    depths_.push_back(index);
    if (depths_.size() > TouchScene::k_max_depths)
      return too_many("too many objects touched by depth images", static_cast<int>(depths_.size()),
                      TouchScene::k_max_depths);
  }
  if (mesh.mover >= TouchScene::k_max_movers)
    return too_many("too many meshes that move", mesh.mover + 1, TouchScene::k_max_movers);
  if (mesh.mover >= 0) {
    int& moved = movers_[static_cast<std::size_t>(mesh.mover)];
    if (moved >= 0)
      return Error{.what = "two meshes have the same mover index",
                   .where = mesh.name,
                   .found = std::to_string(mesh.mover),
                   .expected = "another TouchItem::mover for each mesh"};
    moved = index;
  }
  dvec3 low = mesh.tree->low(), high = mesh.tree->high();
  if (mesh.depth) {
    mesh.depth->bounds(low, high);
    // Includes its motion until the next set.
    if (mesh.mover >= 0 && low.x <= high.x) low -= k_max_motion, high += k_max_motion;
  }
  boxes_.push_back(mesh.mover < 0 ? world_box(low, high, mesh.placement) : Box{low, high});
  return std::nullopt;
}

std::array<Placement, TouchScene::k_max_movers> SceneLayout::placements_of(
    const TouchScene& scene, const TouchState& touch_state, const ProxyInput& input) const noexcept {
  std::array<Placement, TouchScene::k_max_movers> placements;
  for (std::size_t m = 0; m < placements.size(); ++m)
    if (const int shape = movers_[m]; shape >= 0) {
      placements[m] = given_placement(item_of(scene, shape), input);
      if (const int d = depth_index(shape); d >= 0)
        if (const depth::DepthSet* set = depth::set_in(touch_state, d))
          placements[m] = placements[m] * set->displacement_at(input.time);
    }
  return placements;
}

ShapeSet SceneLayout::adopt_sets(const TouchScene& scene, const TouchState& touch_state,
                                 const ProxyInput& input, Surroundings& around) const noexcept {
  ShapeSet adopted;
  for (std::size_t d = 0; d < depths_.size(); ++d) {
    const depth::DepthSet* set = depth::set_in(touch_state, static_cast<int>(d));
    const std::uint64_t serial = set ? set->serial : 0;
    const std::uint64_t last = std::exchange(around.sets[d], serial);
    if (serial == last) continue;
    adopted.set(depths_[d], true);
    const int mover = item_of(scene, depths_[d]).mover;
    if (!set || mover < 0) continue;
    // Converts the previous placement by the displacement that the previous set predicted. The new images may
    // show another displacement; the difference is a motion of the object in this step.
    Placement& previous = around.placements[static_cast<std::size_t>(mover)];
    previous = last + 1 == serial && last > 0
                   ? previous * set->extrapolated.inverse()
                   : given_placement(item_of(scene, depths_[d]), input) * set->displacement_at(around.time);
  }
  around.time = input.time;
  return adopted;
}

const Placement& SceneLayout::given_placement(const TouchItem& mesh, const ProxyInput& input) noexcept {
  const bool is_set = mesh.mover >= 0 && static_cast<std::size_t>(mesh.mover) < input.movers.size();
  return is_set ? input.movers[static_cast<std::size_t>(mesh.mover)] : mesh.placement;
}

Result<SceneLayout> SceneLayout::of(const TouchScene& scene) {
  if (item_count(scene) > ShapeSet::k_max)
    return too_many("too many shapes and meshes to touch at once", item_count(scene), ShapeSet::k_max);
  SceneLayout layout;
  layout.movers_.fill(-1);
  for (int i = 0; i < item_count(scene); ++i) {
    const TouchItem& item = item_of(scene, i);
    layout.depth_of_.push_back(-1);
    if (Status error = item.is_mesh() ? layout.add_mesh(item, i) : layout.add_voxels(scene, i)) return *error;
  }
  if (static_cast<int>(layout.parts_.size()) > k_max_volumes)
    return too_many("too many volumes to touch at once", static_cast<int>(layout.parts_.size()),
                    k_max_volumes);
  // If there are volumes, only their voxels determine the frame's step, which limits the length of legs. A
  // tiny model would make all legs tiny.
  double finest = layout.parts_.empty() ? k_step : 1e300;
  for (const TouchItem& item : scene.items) {
    if (!item.is_mesh()) {
      const dvec3& spacing = item.field.volume().frame.spacing();
      finest = std::min({finest, spacing.x, spacing.y, spacing.z});
    } else if (const double size = glm::length(item.tree->high() - item.tree->low());
               layout.parts_.empty() && item.tree->triangle_count() > 0 && size > 0) {
      finest = std::min(finest, size / k_steps_across);
    }
  }
  auto frame = volume::Frame::from_spacing(scene.base ? scene.base->frame.origin() : dvec3(0), dvec3(finest));
  if (!frame) return frame.error();
  layout.frame_ = frame.value();
  for (Part& part : layout.parts_) {
    part.plane_distance = 1e300;
    for (int k = 0; k < 3; ++k) {
      part.from_scene[k] = part.frame->vector_volume_from_world(layout.frame_.axes()[k]);
      dvec3 axis(0);
      axis[k] = 1;
      part.plane_distance =
          std::min(part.plane_distance, 1 / glm::length(part.frame->gradient_world_from_volume(axis)));
    }
    // Steps of the volume, or of its cut lattice, per step of the scene's frame.
    const glm::dmat3& map = part.from_scene;
    dvec3 steps = glm::abs(map[0]) + glm::abs(map[1]) + glm::abs(map[2]);
    if (scene.lattice && !part.uncut) steps *= scene.lattice->scale();
    layout.sample_mm_ = std::min(layout.sample_mm_, finest / std::max({steps.x, steps.y, steps.z}));
  }
  return layout;
}

SceneWalls::SceneWalls(const TouchScene& scene, const SceneLayout& layout, const TouchState& touch_state,
                       const ProxyState& state, std::span<const Placement> placements,
                       ProxyCounters& counters) noexcept
    : scene_(scene),
      layout_(layout),
      touch_state_(touch_state),
      state_(state),
      placements_(placements),
      counters_(counters) {}

int SceneWalls::part_of(int shape) const noexcept {
  int i = 0;
  while (part(i).end <= shape) ++i;
  return i;
}

SmoothWalls& SceneWalls::walls_of(int i) noexcept {
  SmoothWalls& walls = walls_[static_cast<std::size_t>(i)].walls;
  if (bool& is_constructed = is_constructed_[static_cast<std::size_t>(i)]; !is_constructed) {
    is_constructed = true;
    new (&walls) SmoothWalls(scene_, part(i).uncut ? *part(i).uncut : touch_state_, state_.around.passable,
                             counters_, part(i).begin, part(i).end, &state_.around.nearby);
    if (large_) walls.use(*large_);
  }
  return walls;
}

const MeshTree& SceneWalls::tree_of(int mesh) const noexcept {
  const int d = layout_.depth_index(mesh);
  if (d < 0) return *item_of(scene_, mesh).tree;
  const depth::DepthSet* set = depth::set_in(touch_state_, d);
  static const MeshTree k_nothing;
  return set ? *set->tree : k_nothing;
}

const Placement& SceneWalls::placement_of(int shape) const noexcept {
  const TouchItem& mesh = item_of(scene_, shape);
  return mesh.mover < 0 ? mesh.placement : placements_[static_cast<std::size_t>(mesh.mover)];
}

bool SceneWalls::reach_mesh(int shape, const dvec3& a, const dvec3& b, double tolerance, double latest,
                            Reach& reach) noexcept {
  const bool is_front = blocks(shape, Side::front), is_back = blocks(shape, Side::back);
  if (!is_front && !is_back) return false;
  const dvec3 from = in_mesh(shape, a), to = in_mesh(shape, b);
  const double step = frame().spacing().x, lead = 0.5 * tolerance / (step * glm::length(b - a));
  FacetHit hit;
  if (!tree_of(shape).cast(from, to, scene_.tool->radius(), is_front, is_back, hit, counters_.triangles,
                           std::min(1.0, latest + lead)) ||
      (reach.is_blocked && hit.t >= reach.t))
    return false;
  // The motion stops before the facet, at a distance at which rounding cannot put the proxy behind it.
  const double approach = -glm::dot(to - from, hit.normal_world);
  const double safe = approach > 0 ? hit.t - k_min_gap * step / approach : 0;
  reach.t = std::clamp(std::max(hit.t - lead, 0.5 * hit.t), 0.0, std::max(0.0, safe));
  reach.is_blocked = true;
  reach.wall = {shape, false, hit.side == Side::back, hit.triangle};
  return true;
}

Reach SceneWalls::reach(const dvec3& a, const dvec3& b, ShapeSet& inside, double tolerance, int skipped,
                        double latest) noexcept {
  Reach first;
  const ShapeSet before = inside;
  ShapeSet after = inside;
  int blocking = -1;
  for (int i = 0; i < static_cast<int>(layout_.parts().size()); ++i) {
    if (state_.around.nearby.next(part(i).begin) >= part(i).end) continue;
    // Each volume changes `after` up to its own end of the motion. If another wall stops the motion earlier,
    // the changes are computed again below.
    const Reach part_hit = walls_of(i).reach(in_part(i, a), in_part(i, b), after, tolerance);
    if (part_hit.is_blocked && (!first.is_blocked || part_hit.t < first.t)) first = part_hit, blocking = i;
  }
  for (int s = next_shape(0); s < ShapeSet::k_max; s = next_shape(s + 1))
    if (is_mesh(s) && s != skipped && reach_mesh(s, a, b, tolerance, latest, first)) blocking = -1;
  if (first.is_blocked && after != before) {
    after = before;
    const dvec3 end = a + first.t * (b - a);
    for (int i = 0; i < static_cast<int>(layout_.parts().size()); ++i)
      if (state_.around.nearby.next(part(i).begin) < part(i).end)
        walls_of(i).reach(in_part(i, a), in_part(i, i == blocking ? b : end), after, tolerance);
  }
  inside = after;
  return first;
}

bool SceneWalls::is_free_within(int shape, const dvec3& p, double mm) noexcept {
  if (is_mesh(shape)) {
    if (!blocks(shape, Side::front) && !blocks(shape, Side::back)) return true;
    return !tree_of(shape).is_near(in_mesh(shape, p), mm);
  }
  const int i = part_of(shape);
  return walls_of(i).is_free_within(shape, in_part(i, p), mm / part(i).plane_distance, mm);
}

std::size_t SceneWalls::find_facets(int mesh, const dvec3& p, double mm, std::span<MeshTree::Facet> facets,
                                    std::span<const MeshTree::Facet> candidates) const noexcept {
  if (!blocks(mesh, Side::front) && !blocks(mesh, Side::back)) return 0;
  const dvec3 at = in_mesh(mesh, p);
  if (!candidates.data()) return tree_of(mesh).find_near(at, mm, facets);
  std::size_t count = 0;
  for (const MeshTree::Facet& facet : candidates) {
    if (!facet.may_be_within(at, mm)) continue;
    if (count < facets.size()) facets[count] = facet;
    ++count;
  }
  return count;
}

bool SceneWalls::is_solid(int shape, const dvec3& p) noexcept {
  if (is_mesh(shape)) return false;
  const int i = part_of(shape);
  return walls_of(i).is_solid(shape, in_part(i, p));
}

volume::Jet SceneWalls::jet(const Wall& wall, const dvec3& p) noexcept {
  if (is_mesh(wall.shape)) {
    const Placement& placement = placement_of(wall.shape);
    const dvec3 at = in_mesh(wall.shape, p);
    // A ball rolls over edges: the nearest of the facets that are connected to this one counts.
    const MeshTree& tree = tree_of(wall.shape);
    const std::uint32_t facet =
        scene_.tool->radius() > 0 ? tree.nearest_connected(wall.facet, at, counters_.triangles) : wall.facet;
    const auto [u, v, w] = tree.corners(facet);
    const double step = frame().spacing().x;
    volume::Jet jet{};
    if (!(scene_.tool->radius() > 0)) {
      dvec3 normal = glm::normalize(glm::cross(v - u, w - u));
      if (wall.is_back) normal = -normal;
      jet.value = -glm::dot(normal, at - u);
      jet.gradient = -step * (placement.rotation * normal);
      return jet;
    }
    // radius - distance: curved like a sphere around a corner, like a cylinder around an edge.
    TriangleFeature feature;
    const dvec3 off = at - nearest_on_triangle(at, u, v, w, &feature);
    const double distance = glm::length(off);
    jet.value = scene_.tool->radius() - distance;
    if (!(distance > 0)) return jet;
    const dvec3 n = placement.rotation * (off / distance);
    jet.gradient = -step * n;
    if (feature == TriangleFeature::face) return jet;
    const double curvature = -step * step / distance;
    jet.hessian_diagonal = curvature * (1.0 - n * n);
    jet.hessian_mixed = -curvature * dvec3(n.y * n.z, n.x * n.z, n.x * n.y);
    if (feature == TriangleFeature::corner) return jet;
    const dvec3 edge = feature == TriangleFeature::edge_ab   ? v - u
                       : feature == TriangleFeature::edge_bc ? w - v
                                                             : w - u;
    const dvec3 e = placement.rotation * glm::normalize(edge);
    jet.hessian_diagonal -= curvature * (e * e);
    jet.hessian_mixed -= curvature * dvec3(e.y * e.z, e.x * e.z, e.x * e.y);
    return jet;
  }
  const int i = part_of(wall.shape);
  const glm::dmat3& map = part(i).from_scene;
  const volume::Jet own = walls_of(i).jet(wall, in_part(i, p));
  volume::Jet jet;
  jet.value = own.value;
  jet.gradient = own.gradient * map;
  const dvec3 bent[3] = {own.hessian_times(map[0]), own.hessian_times(map[1]), own.hessian_times(map[2])};
  jet.hessian_diagonal = {glm::dot(map[0], bent[0]), glm::dot(map[1], bent[1]), glm::dot(map[2], bent[2])};
  jet.hessian_mixed = {glm::dot(map[1], bent[2]), glm::dot(map[0], bent[2]), glm::dot(map[0], bent[1])};
  return jet;
}

volume::ValueAndGradient SceneWalls::value_and_gradient(const Wall& wall, const dvec3& p) noexcept {
  if (is_mesh(wall.shape)) return jet(wall, p);
  const int i = part_of(wall.shape);
  const volume::ValueAndGradient own = walls_of(i).value_and_gradient(wall, in_part(i, p));
  return {own.value, own.gradient * part(i).from_scene};
}

volume::QuadraticPatch::HessianBound SceneWalls::hessian_bound(const Wall& wall, const Span& span,
                                                               bool& is_whole, int most) noexcept {
  is_whole = false;
  // A straight motion along a facet, or of a ball along its tangent plane, does not enter the facet. The
  // bound may therefore be 0.
  if (is_mesh(wall.shape)) return {dvec3(0), dvec3(0)};
  const int i = part_of(wall.shape);
  const volume::QuadraticPatch::HessianBound own =
      walls_of(i).hessian_bound(wall, {in_part(i, span.a), in_part(i, span.b)}, is_whole, most);
  return in_scene_frame(own, i);
}

volume::QuadraticPatch::HessianBound SceneWalls::hessian_bound_around(const Wall& wall, const dvec3& p,
                                                                      double reach, bool& is_whole,
                                                                      int most) noexcept {
  is_whole = false;
  if (is_mesh(wall.shape)) return {dvec3(0), dvec3(0)};
  const int i = part_of(wall.shape);
  // Box in the frame of the volume that contains the box in the frame of the scene.
  const glm::dmat3& map = part(i).from_scene;
  const dvec3 extent = reach * (glm::abs(map[0]) + glm::abs(map[1]) + glm::abs(map[2])), own = in_part(i, p);
  return in_scene_frame(walls_of(i).hessian_bound(wall, {own - extent, own + extent}, is_whole, most), i);
}

/// Returns bounds of a volume's function along the axes of the scene.
volume::QuadraticPatch::HessianBound SceneWalls::in_scene_frame(
    const volume::QuadraticPatch::HessianBound& own, int i) const noexcept {
  const glm::dmat3 map(glm::abs(part(i).from_scene[0]), glm::abs(part(i).from_scene[1]),
                       glm::abs(part(i).from_scene[2]));
  const volume::Jet as_jet{{0, dvec3(0)}, own.pure, own.cross};
  const dvec3 bent[3] = {as_jet.hessian_times(map[0]), as_jet.hessian_times(map[1]),
                         as_jet.hessian_times(map[2])};
  return {{glm::dot(map[0], bent[0]), glm::dot(map[1], bent[1]), glm::dot(map[2], bent[2])},
          {glm::dot(map[1], bent[2]), glm::dot(map[0], bent[2]), glm::dot(map[0], bent[1])}};
}

dvec3 SceneWalls::above_step(const Wall& wall, const dvec3& p, std::span<const dvec3> normals_world,
                             glm::bvec3& is_kept) noexcept {
  if (is_mesh(wall.shape)) return p;
  const int i = part_of(wall.shape);
  const dvec3 own = in_part(i, p), above = walls_of(i).above_step(wall, own, normals_world, is_kept);
  if (above == own) return p;
  return frame().volume_from_world(part(i).frame->world_from_volume(above));
}

bool SceneWalls::is_near_crease(int shape, const dvec3& p) noexcept {
  if (is_mesh(shape)) return false;
  const int i = part_of(shape);
  return walls_of(i).is_near_crease(shape, in_part(i, p));
}

int SceneWalls::walls_at(int shape, const ShapeSet& inside, const dvec3& p, double within, WallList& walls,
                         NearFacets* near_facets) noexcept {
  if (near_facets) near_facets->is_complete = false;
  if (!is_mesh(shape)) {
    const int i = part_of(shape);
    SmoothWalls::WallList few;
    const int count = walls_of(i).walls_at(shape, inside, in_part(i, p), within, few);
    std::copy_n(few.begin(), count, walls.begin());
    return count;
  }
  const dvec3 at = in_mesh(shape, p);
  const MeshTree& tree = tree_of(shape);
  const double radius = scene_.tool->radius();
  const bool is_front = blocks(shape, Side::front), is_back = blocks(shape, Side::back);
  // Collects at most k_max facets, nearest first.
  constexpr std::size_t k_max = 12;
  std::array<MeshTree::Near, k_max> nearest;
  std::size_t found = 0;
  double reach = radius + within;
  // Facets that the tool passes from its side; it may not pass them when it comes back.
  std::array<std::uint32_t, k_max> passable;
  std::size_t passable_count = 0;
  const auto add_candidate = [&](const MeshTree::Near& candidate) {
    ++counters_.triangles;
    if (candidate.is_front ? !is_front : !is_back) {
      if (passable_count < k_max) passable[passable_count] = candidate.triangle;
      ++passable_count;
      return;
    }
    std::size_t place = std::min(found, k_max - 1);
    if (found == k_max && candidate.distance >= nearest[place].distance) return;
    for (; place > 0 && candidate.distance < nearest[place - 1].distance; --place)
      nearest[place] = nearest[place - 1];
    nearest[place] = candidate;
    found = std::min(found + 1, k_max);
    if (found == k_max) reach = nearest[k_max - 1].distance;
  };
  if (near_facets && near_facets->candidates.data())
    MeshTree::for_near(near_facets->candidates, at, reach, add_candidate);
  else
    tree.for_near(at, reach, add_candidate);
  // Leaves out facets that are wholly behind a nearer facet, so that they do not stop the tool at edges that
  // it can pass.
  const double slack = 1e-9 * frame().spacing().x;
  std::array<MeshTree::Near, std::tuple_size_v<WallList>> kept;
  int count = 0;
  const auto is_behind = [&](std::uint32_t triangle, const MeshTree::Near& other) {
    const dvec3 out = other.is_front ? other.normal : -other.normal;
    for (const dvec3& corner : tree.corners(triangle))
      if (glm::dot(out, corner - other.nearest) > slack) return false;
    return true;
  };
  bool are_all_behind = near_facets && found < k_max && passable_count <= k_max && !(radius > 0);
  for (std::size_t k = 0; k < found; ++k) {
    const MeshTree::Near& facet = nearest[k];
    if (count == static_cast<int>(walls.size())) {
      are_all_behind = false;
      break;
    }
    bool is_omitted = facet.is_front != nearest[0].is_front && !(radius > 0);
    if (is_omitted) are_all_behind = false;
    for (int j = 0; j < count && !is_omitted; ++j) {
      const MeshTree::Near& other = kept[static_cast<std::size_t>(j)];
      if (radius > 0) {
        const dvec3 out = (at - other.nearest) / std::max(other.distance, 1e-300);
        is_omitted = !(glm::dot(out, facet.nearest - other.nearest) > slack);
      } else {
        is_omitted = is_behind(facet.triangle, other);
      }
    }
    if (is_omitted) continue;
    kept[static_cast<std::size_t>(count)] = facet;
    walls[static_cast<std::size_t>(count++)] = {shape, false, !facet.is_front, facet.triangle};
  }
  for (std::size_t k = 0; k < passable_count && are_all_behind; ++k)
    are_all_behind = std::any_of(kept.begin(), kept.begin() + count,
                                 [&](const MeshTree::Near& other) { return is_behind(passable[k], other); });
  if (near_facets) near_facets->is_complete = are_all_behind;
  return count;
}

}  // namespace trephine::haptics
