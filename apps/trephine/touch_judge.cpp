#include "apps/trephine/touch_judge.h"

#include <algorithm>
#include <glm/geometric.hpp>

#include "haptics/mesh/mesh_tree.h"

namespace trephine::app {

namespace {

/// Judges for the models, in the volume's frame: their triangles, or what images of them show, which is what
/// a method on those promises.
std::vector<std::unique_ptr<checker::MeshWall>> mesh_walls(const haptics::TouchScene& scene,
                                                           bool is_by_images) {
  std::vector<std::unique_ptr<checker::MeshWall>> walls;
  for (const haptics::TouchItem& mesh : scene.items) {
    if (!mesh.is_mesh() || mesh.depth) continue;
    std::vector<glm::dvec3> vertices;
    std::vector<std::uint32_t> triangles;
    if (is_by_images) {
      const scenes::ShownModel shown = scenes::shown_by_images(mesh);
      for (const glm::dvec3& v : shown.vertices)
        vertices.push_back(scene.base->frame.volume_from_world(mesh.placement.world_from_local(v)));
      triangles = shown.triangles;
      walls.push_back(std::make_unique<checker::MeshWall>(vertices, triangles, 1.0));
      continue;
    }
    double longest = 1;
    for (std::uint32_t t = 0; t < mesh.tree->triangle_count(); ++t)
      for (const glm::dvec3& corner : mesh.tree->corners(t)) {
        triangles.push_back(static_cast<std::uint32_t>(vertices.size()));
        vertices.push_back(scene.base->frame.volume_from_world(mesh.placement.world_from_local(corner)));
        longest = std::max(longest, glm::length(vertices.back() - vertices[3 * t]));
      }
    walls.push_back(std::make_unique<checker::MeshWall>(vertices, triangles, std::max(1.0, longest / 8)));
  }
  return walls;
}

}  // namespace

TouchJudge::TouchJudge(const workbench::Operation& operation)
    : scene_(*operation.scene()),
      base_(*operation.source.volume),
      info_(*haptics::find_method(operation.method().name())),
      is_smooth_(info_.solid == haptics::MethodInfo::Solid::smooth),
      solid_(checker::solid_voxels(operation.source.volume, scene_.items[0].field.shape())),
      promise_(info_, scene_),
      offset_(scenes::touched_offset(scene_, nullptr)),
      smooth_(scenes::touched_smooth_solid(scene_, nullptr)),
      falls_([this](const glm::dvec3& a, const glm::dvec3& b) { return meets(a, b); }) {
  const auto shapes = base_shapes(scene_);
  for (std::size_t i = 1; i < shapes.size(); ++i)
    if (shapes[i].sides == haptics::Side::front)
      others_.push_back(std::make_unique<scenes::Promise>(info_, scene_, nullptr, i));
  if (std::string(info_.name) != "scene-sequential")
    models_ = mesh_walls(scene_, info_.solid == haptics::MethodInfo::Solid::images);
  has_drawn_ = std::any_of(scene_.items.begin(), scene_.items.end(),
                           [](const haptics::TouchItem& item) { return item.depth != nullptr; });
  // A look asks every triangle: 5 ms a tick at most.
  constexpr std::size_t k_triangles_a_tick = 2000;
  for (const haptics::TouchItem& item : scene_.items)
    if (item.depth && item.tree)
      look_every_ = std::max<std::uint64_t>(look_every_, item.tree->triangle_count() / k_triangles_a_tick);
}

bool TouchJudge::meets(const glm::dvec3& a, const glm::dvec3& b) const {
  if (promise_.meets(a, b)) return true;
  for (const auto& other : others_)
    if (other->meets(a, b)) return true;
  for (const auto& wall : models_)
    if (a != b && wall->is_entered(a, b)) return true;
  return false;
}

glm::dvec3 TouchJudge::judged(const glm::dvec3& p_volume) const {
  return offset_ ? offset_->frame().volume_from_world(base_.frame.world_from_volume(p_volume)) : p_volume;
}

void TouchJudge::observe(const workbench::TouchTick& tick) {
  const haptics::ServoRecord& record = tick.record;
  const haptics::ProxyStep& step = tick.servo.last_step();
  const glm::dvec3& place = record.pose.position_world;
  const glm::dvec3 hip = base_.frame.volume_from_world(place);
  // What moves by itself takes the proxy along: through nothing else.
  if (const glm::dvec3* last = falls_.free_proxy();
      last && has_drawn_ && !step.is_buried && step.waypoint_count > 0 && step.path_volume[0] != *last)
    falls_.carried_to(step.path_volume[0], meets(*last, step.path_volume[0]));
  falls_.judge_step({std::span(step.path_volume.data(), static_cast<std::size_t>(step.waypoint_count)), hip,
                     step.has_contact, step.is_buried});
  for (std::size_t e = 0; e < record.event_count; ++e)
    if (record.events[e].kind == haptics::TouchEvent::popped) {  // let through, as asked
      falls_.restart();
      popped_ = record.events[e].shape;
    }
  if (!record.has_contact && popped_ >= 0) drawn_.restart(), popped_ = -1;
  if (has_drawn_ && record.tick % look_every_ == 0)
    drawn_.judge(tick.felt, record.proxy_world, tick.t, popped_);
  // On cubes each tick at rest is looked at, on the smooth solid, which takes milliseconds, the tenth of each
  // rest; with models about, none.
  resting_ = record.has_contact && glm::length(place - last_hip_) < 1e-6 ? resting_ + 1 : 0;
  last_hip_ = place;
  if (models_.empty() && !has_drawn_ && (is_smooth_ || scene_.tool_radius == 0) &&
      (is_smooth_ ? resting_ == 10 : resting_ >= 10))
    stuck_ += is_stuck(tick, hip);
}

/// Farther than a voxel, and than friction holds it, from where a frictionless proxy on the same solid is.
bool TouchJudge::is_stuck(const workbench::TouchTick& tick, const glm::dvec3& hip) const {
  const volume::Frame& frame = is_smooth_ && offset_ ? offset_->frame() : base_.frame;
  const glm::dvec3& at = tick.servo.proxy_state().proxy_volume;
  const glm::dvec3 axes[3] = {base_.frame.axes()[0], base_.frame.axes()[1], base_.frame.axes()[2]};
  const glm::dvec3 rest =
      is_smooth_ ? checker::sweep_ideal_proxy(smooth_, frame.axes(), judged(at), judged(hip), judged(hip), 1)
                 : checker::resting_point_on_cubes(base_.size, solid_, axes, at, hip);
  const haptics::ServoRecord& record = tick.record;
  const double off = glm::length(frame.world_from_volume(rest) - record.proxy_world);
  return off > base_.frame.diagonal_mm() + scene_.items[0].material.static_friction *
                                               glm::length(record.proxy_world - record.pose.position_world);
}

}  // namespace trephine::app
