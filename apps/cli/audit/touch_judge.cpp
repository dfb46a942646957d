#include "apps/cli/audit/touch_judge.h"

#include <algorithm>
#include <glm/geometric.hpp>

#include "haptics/depth/depth_model.h"
#include "haptics/depth/depth_source.h"
#include "haptics/mesh/mesh_tree.h"

namespace trephine::cli {

namespace {

/// Returns a judge of the triangles of a model, with its vertices mapped by `map`.
template <class Map>
verify::MeshWall wall_of(const std::vector<glm::dvec3>& vertices, const std::vector<std::uint32_t>& triangles,
                         double min_cube, const Map& map) {
  std::vector<glm::dvec3> mapped;
  mapped.reserve(vertices.size());
  for (const glm::dvec3& v : vertices) mapped.push_back(map(v));
  double longest = min_cube;
  for (std::size_t i = 0; i < triangles.size(); ++i)
    longest = std::max(longest, glm::length(mapped[triangles[i]] - mapped[triangles[i - i % 3]]));
  return {mapped, triangles, std::max(min_cube, longest / 8)};
}

/// Returns judges for the models that a method touches by their triangles, in the volume's frame.
std::vector<std::unique_ptr<verify::MeshWall>> mesh_walls(const haptics::TouchScene& scene) {
  std::vector<std::unique_ptr<verify::MeshWall>> walls;
  for (const haptics::TouchItem& mesh : scene.items)
    if (mesh.is_mesh() && !mesh.depth)
      walls.push_back(std::make_unique<verify::MeshWall>(
          wall_of(mesh.tree->vertices(), mesh.tree->triangles(), 1, [&](const glm::dvec3& v) {
            return scene.base->frame.volume_from_world(mesh.placement.world_from_local(v));
          })));
  return walls;
}

}  // namespace

TouchJudge::TouchJudge(const workbench::Operation& operation)
    : scene_(*operation.scene()),
      base_(*operation.source.volume),
      info_(*haptics::find_method(operation.method().name())),
      is_smooth_(info_.solid == haptics::MethodInfo::Solid::smooth),
      solid_(verify::solid_voxels(operation.source.volume, scene_.items[0].field.shape())),
      guaranteed_(info_, scene_),
      offset_(scenes::touch_offset_field(scene_, nullptr)),
      smooth_(scenes::touched_smooth_solid(scene_, nullptr)),
      falls_([this](const glm::dvec3& a, const glm::dvec3& b) { return meets(a, b); }) {
  const auto shapes = base_shapes(scene_);
  for (std::size_t i = 1; i < shapes.size(); ++i)
    if (shapes[i].sides == haptics::Side::front)
      others_.push_back(std::make_unique<scenes::GuaranteedSolid>(info_, scene_, nullptr, i));
  const bool is_by_images = info_.solid == haptics::MethodInfo::Solid::images;
  // scene-sequential does not promise to stay outside models: its volume pipeline may push the proxy into
  // one.
  if (std::string(info_.name) != "scene-sequential" && !is_by_images) models_ = mesh_walls(scene_);
  const auto identity = [](const glm::dvec3& v) { return v; };
  for (std::size_t i = 0; i < scene_.items.size(); ++i) {
    const haptics::TouchItem& item = scene_.items[i];
    if (const auto* model = dynamic_cast<const haptics::depth::DepthModel*>(item.depth.get())) {
      if (model->keys().keys.size() == 1)
        imaged_.push_back(
            {i,
             {wall_of(model->keys().keys[0], model->keys().triangles, 1, identity), item.depth_pixel},
             {}});
    } else if (item.is_mesh() && !item.depth && is_by_images) {
      imaged_.push_back(
          {i, {wall_of(item.tree->vertices(), item.tree->triangles(), 1, identity), item.depth_pixel}, {}});
    }
  }
  has_depth_objects_ = std::any_of(scene_.items.begin(), scene_.items.end(),
                                   [](const haptics::TouchItem& item) { return item.depth != nullptr; });
  // A judgement visits every triangle; longer intervals for large models limit the mean time per tick.
  constexpr std::size_t k_triangles_per_tick = 2000;
  for (const haptics::TouchItem& item : scene_.items)
    if (item.depth && item.tree)
      depth_interval_ =
          std::max<std::uint64_t>(depth_interval_, item.tree->triangle_count() / k_triangles_per_tick);
}

bool TouchJudge::meets(const glm::dvec3& a, const glm::dvec3& b) const {
  if (guaranteed_.meets(a, b)) return true;
  for (const auto& other : others_)
    if (other->meets(a, b)) return true;
  for (const auto& wall : models_)
    if (a != b && wall->is_entered(a, b)) return true;
  return false;
}

glm::dvec3 TouchJudge::to_smooth_frame(const glm::dvec3& p_volume) const {
  return offset_ ? offset_->frame().volume_from_world(base_.frame.world_from_volume(p_volume)) : p_volume;
}

void TouchJudge::observe(const workbench::TouchTick& tick) {
  const haptics::ServoRecord& record = tick.record;
  const haptics::ProxyStep& step = tick.servo.last_step();
  const glm::dvec3& position = record.pose.position_world;
  const glm::dvec3 hip = base_.frame.volume_from_world(position);
  if (scene_.tool->is_six_dof()) return;  // its origin is no point of the tool
  // A moving object may carry the proxy along, but must not carry it through another object.
  if (const glm::dvec3* last = falls_.free_proxy(); last && has_depth_objects_ && !step.is_buried &&
                                                    step.waypoint_count > 0 && step.path_volume[0] != *last)
    falls_.set_carried_proxy(step.path_volume[0], meets(*last, step.path_volume[0]));
  falls_.judge_step({std::span(step.path_volume.data(), static_cast<std::size_t>(step.waypoint_count)), hip,
                     step.has_contact, step.is_buried});
  for (std::size_t e = 0; e < record.event_count; ++e)
    if (record.events[e].kind == haptics::TouchEvent::popped) {  // passage is allowed
      falls_.restart();
      popped_ = record.events[e].shape;
    }
  judge_passages(tick);
  if (!record.has_contact && popped_ >= 0) depth_judge_.restart(), popped_ = -1;
  if (has_depth_objects_ && record.tick % depth_interval_ == 0)
    depth_judge_.judge(tick.servo_hand, record.proxy_world, tick.t, popped_);
  // A hand at rest in contact is judged from its tenth tick on. On cubes, points are judged in every tick,
  // and round tools not at all. On the smooth solid, where a judgement costs milliseconds, each rest is
  // judged once. Scenes with models are not judged.
  resting_ = record.has_contact && glm::length(position - last_hip_) < 1e-6 ? resting_ + 1 : 0;
  last_hip_ = position;
  if (models_.empty() && imaged_.empty() && !has_depth_objects_ &&
      (is_smooth_ || scene_.tool->radius() == 0) && (is_smooth_ ? resting_ == 10 : resting_ >= 10))
    stuck_ += is_stuck(tick, hip);
}

namespace {
/// Returns true if the images by which the hand touches an item cover the neighbourhood of a proxy (frame of
/// the item).
bool is_imaged(const workbench::TouchTick& tick, std::size_t index, const glm::dvec3& proxy_local) {
  int depth = 0;
  for (std::size_t i = 0; i < index; ++i) depth += tick.servo_hand.scene->items[i].depth != nullptr;
  const haptics::depth::DepthSet* set = haptics::depth::set_in(tick.servo_hand.state, depth);
  return set != nullptr && set->is_known_around(proxy_local, tick.servo_hand.scene->tool->radius());
}
}  // namespace

/// Judges the models that the method touches by depth images. The judge uses the triangles of each model, in
/// the model's frame.
void TouchJudge::judge_passages(const workbench::TouchTick& tick) {
  const haptics::ServoRecord& record = tick.record;
  for (ImagedModel& model : imaged_) {
    const haptics::TouchItem& item = scene_.items[model.item];
    const auto mover = static_cast<std::size_t>(item.mover);
    const haptics::Placement placement = item.mover >= 0 && mover < tick.servo_hand.placement_count
                                             ? tick.servo_hand.placements[mover]
                                             : item.placement;
    const glm::dvec3 proxy_local = placement.local_from_world(record.proxy_world);
    const bool is_let_through = (tick.servo_hand.untouchable | tick.servo_hand.passable_items)
                                    .contains(static_cast<int>(model.item)) ||
                                popped_ == static_cast<int>(model.item);
    // A hand that is faster than the updates of the images leaves the region that they cover. The method
    // guarantees nothing there.
    const bool is_covered = !item.depth || is_imaged(tick, model.item, proxy_local);
    if (is_let_through || !is_covered || record.is_reset || record.is_restarted ||
        tick.servo.last_step().is_buried)
      model.has_last = false;
    if (!model.has_last) model.judge.restart();
    // Judge along the path of the proxy if the model is at rest, otherwise along a straight line.
    glm::dvec3 from = model.last;
    const haptics::ProxyStep& step = tick.servo.last_step();
    if (model.has_last && item.mover < 0)
      for (int i = 0; i < step.waypoint_count; ++i) {
        const glm::dvec3 to = placement.local_from_world(
            base_.frame.world_from_volume(step.path_volume[static_cast<std::size_t>(i)]));
        passed_ += model.judge.passes(from, to);
        from = to;
      }
    if (model.has_last) passed_ += model.judge.passes(from, proxy_local);
    model.last = proxy_local;
    model.has_last = !is_let_through && is_covered;
  }
}

/// True if the proxy is farther from the frictionless proxy on the same solid than a voxel's diagonal plus
/// the distance that friction can hold.
bool TouchJudge::is_stuck(const workbench::TouchTick& tick, const glm::dvec3& hip) const {
  const volume::Frame& frame = is_smooth_ && offset_ ? offset_->frame() : base_.frame;
  const glm::dvec3& at = tick.servo.proxy_state().proxy_volume;
  const glm::dvec3 axes[3] = {base_.frame.axes()[0], base_.frame.axes()[1], base_.frame.axes()[2]};
  const glm::dvec3 rest = is_smooth_
                              ? verify::sweep_ideal_proxy(smooth_, frame.axes(), to_smooth_frame(at),
                                                          to_smooth_frame(hip), to_smooth_frame(hip), 1)
                              : verify::resting_point_on_cubes(base_.size, solid_, axes, at, hip);
  const haptics::ServoRecord& record = tick.record;
  const double distance = glm::length(frame.world_from_volume(rest) - record.proxy_world);
  return distance >
         base_.frame.diagonal_mm() + scene_.items[0].material.static_friction *
                                         glm::length(record.proxy_world - record.pose.position_world);
}

}  // namespace trephine::cli
