// AuditedHand: the judges of one hand of a session, and the solids that they read.
#pragma once

#include <algorithm>
#include <array>
#include <glm/geometric.hpp>
#include <memory>
#include <optional>
#include <vector>

#include "apps/bench/scenes/guaranteed_solid.h"
#include "apps/cli/audit/depth_image_judge.h"
#include "apps/cli/audit/friction_audit.h"
#include "apps/verify/ball_judge.h"
#include "apps/verify/force_judge.h"
#include "apps/verify/mesh_judge.h"
#include "haptics/mesh/mesh_tree.h"
#include "haptics/methods/methods.h"

namespace trephine::cli {

inline const haptics::Material& touched_material(const haptics::TouchScene& scene,
                                                 const haptics::ServoRecord& r) {
  const haptics::TouchItem& shape = scene.items[static_cast<std::size_t>(r.shape)];
  return r.side == haptics::Side::back && shape.back_material ? *shape.back_material : shape.material;
}

/// Returns the stiffness (N/mm) at the proxy, computed from the documented ramp and the intensity one voxel
/// below the surface.
inline double stiffness_at(const haptics::TouchScene& scene, const haptics::ServoRecord& r) {
  const haptics::TouchItem& shape = scene.items[static_cast<std::size_t>(r.shape)];
  const double soft = touched_material(scene, r).stiffness;
  if (!shape.ramp || shape.is_mesh()) return soft;
  const volume::Volume& volume = shape.field.volume();
  const glm::dvec3& spacing = volume.frame.spacing();
  const double voxel = std::min({spacing.x, spacing.y, spacing.z});
  const double offset = r.side == haptics::Side::back ? voxel : -(scene.tool->radius() + voxel);
  const auto intensity =
      verify::intensity_at(volume, volume.frame.volume_from_world(r.proxy_world + offset * r.normal_world));
  if (!intensity) return soft;
  const haptics::StiffnessRamp& ramp = *shape.ramp;
  if (*intensity <= ramp.intensity) return soft;
  if (*intensity >= ramp.dense_intensity) return ramp.dense_stiffness;
  return soft + (ramp.dense_stiffness - soft) * (*intensity - ramp.intensity) /
                    (ramp.dense_intensity - ramp.intensity);
}

/// Judges the position of a round tip by the scan's own samples and cuts.
class BallAudit {
 public:
  explicit BallAudit(const haptics::TouchScene& scene)
      : scene_(scene), judge_(scene.tool->radius()), min_move_(0.01 * scene.tool->radius()) {
    const glm::dvec3& spacing = scene.base->frame.spacing();
    allowed_ = std::min(0.1, 0.2 * std::max({spacing.x, spacing.y, spacing.z})) + 0.02 * scene.tool->radius();
  }
  void set_version(const std::shared_ptr<const volume::Version>& version) {
    solids_.clear();
    for (const haptics::TouchItem& shape : base_shapes(scene_))
      solids_.push_back(verify::smooth_solid(scene_.base, shape.field.shape(), version, shape.soft));
    is_new_ = true;
  }
  /// Judges the tip's centre if the tip has moved by at least 1 % of its radius, or if a cut was made.
  /// `popped`: the shape that the proxy passes through after pop-through; -1 if no shape.
  void judge_centre(const glm::dvec3& centre_world, int popped) {
    if (!is_new_ && glm::length(centre_world - last_) < min_move_) return;
    is_new_ = false, last_ = centre_world;
    const double penetration_mm = judge_.penetration_mm(centre_world, [&](const glm::dvec3& at) {
      const glm::dvec3 p = scene_.base->frame.volume_from_world(at);
      for (std::size_t s = 0; s < solids_.size(); ++s)
        if (static_cast<int>(s) != popped && haptics::blocks(scene_.items[s].sides, haptics::Side::front) &&
            solids_[s].is_solid(p))
          return true;
      return false;
    });
    ++judged_;
    too_deep_ += penetration_mm > allowed_;
    deepest_ = std::max(deepest_, penetration_mm);
  }
  long judged() const { return judged_; }
  long too_deep() const { return too_deep_; }
  double deepest_mm() const { return deepest_; }
  double allowed_mm() const { return allowed_; }

 private:
  const haptics::TouchScene& scene_;
  verify::BallJudge judge_;
  double min_move_, allowed_;
  std::vector<verify::SmoothSolid> solids_;
  bool is_new_ = true;
  glm::dvec3 last_{0.0};
  long judged_ = 0, too_deep_ = 0;
  double deepest_ = 0;
};

/// Touchable solids of one hand, read from samples and triangles with the judges' own code: shapes of the
/// anatomy at the current tick, shapes of other scans, and models at their placements.
class TouchableSolids {
 public:
  /// Adopts the state of a tick. Returns true if the solids may differ from those of the previous tick.
  bool update(const std::shared_ptr<const haptics::ServoHand>& servo_hand) {
    const bool is_other_scene = !servo_hand_ || servo_hand_->scene != servo_hand->scene;
    const bool is_cut = is_other_scene || servo_hand_->state.version != servo_hand->state.version ||
                        servo_hand_->state.offsets != servo_hand->state.offsets;
    const bool has_moved = is_other_scene || servo_hand_->placement_count != servo_hand->placement_count ||
                           servo_hand_->placements != servo_hand->placements;
    const bool is_switched = is_other_scene || !(servo_hand_->untouchable == servo_hand->untouchable) ||
                             !(servo_hand_->passable_items == servo_hand->passable_items);
    servo_hand_ = servo_hand;
    const haptics::TouchScene& scene = *servo_hand->scene;
    if (is_other_scene) update_scene(scene);
    if (is_cut) {
      cut_.clear();
      const auto state = std::shared_ptr<const haptics::TouchState>(servo_hand, &servo_hand->state);
      for (std::size_t s = 0; s < base_shapes(scene).size(); ++s)
        cut_.emplace_back(method(), scene, state, s);
    }
    return is_cut || has_moved || is_switched;
  }
  const haptics::MethodInfo& method() const { return *haptics::find_method(servo_hand_->method->name()); }
  /// True if the segment from a to b (volume frame of the anatomy), or the point if both are equal, meets a
  /// solid whose front blocks this hand. `popped`: the item that the proxy passes through; -1 if no item.
  /// `ignores_movers`: models that move are not tested.
  bool meets(const glm::dvec3& a, const glm::dvec3& b, int popped, bool ignores_movers = false) const {
    const haptics::TouchScene& scene = *servo_hand_->scene;
    const auto blocks = [&](std::size_t item) {
      return haptics::blocks(scene.items[item].sides, haptics::Side::front) &&
             !(servo_hand_->untouchable | servo_hand_->passable_items).contains(static_cast<int>(item)) &&
             popped != static_cast<int>(item);
    };
    for (std::size_t s = 0; s < cut_.size(); ++s)
      if (blocks(s) && cut_[s].meets(a, b)) return true;
    const glm::dvec3 from = scene.base->frame.world_from_volume(a),
                     to = scene.base->frame.world_from_volume(b);
    for (const Uncut& uncut : uncut_) {
      const volume::Frame& frame = uncut.volume->frame;
      if (blocks(uncut.item) && uncut.solid.meets(frame.volume_from_world(from), frame.volume_from_world(to)))
        return true;
    }
    for (const Model& model : models_) {
      const haptics::TouchItem& item = scene.items[model.item];
      if (!blocks(model.item) || (ignores_movers && item.mover >= 0)) continue;
      const haptics::Placement model_placement = placement(item);
      const glm::dvec3 p = model_placement.local_from_world(from), q = model_placement.local_from_world(to);
      if (a == b ? is_in(model, p, scene.tool->radius()) : model.wall.is_entered(p, q)) return true;
    }
    return false;
  }
  /// True if a model may move, or if an item is touched by depth images, whose content may move.
  bool has_movers() const {
    for (const haptics::TouchItem& item : servo_hand_->scene->items)
      if (item.depth) return true;
    return std::any_of(models_.begin(), models_.end(),
                       [&](const Model& m) { return servo_hand_->scene->items[m.item].mover >= 0; });
  }
  haptics::Placement placement(const haptics::TouchItem& item) const {
    const auto mover = static_cast<std::size_t>(item.mover);
    return item.mover >= 0 && mover < servo_hand_->placement_count ? servo_hand_->placements[mover]
                                                                   : item.placement;
  }

 private:
  /// A shape of another scan, which is never cut.
  struct Uncut {
    std::size_t item;
    std::shared_ptr<const volume::Volume> volume;
    scenes::GuaranteedSolid solid;
  };
  struct Model {
    std::size_t item;
    verify::MeshWall wall;
    glm::dvec3 low, high;
  };
  /// True if the model contains the tool's centre, or a point just inside the surface of the tool's ball.
  static bool is_in(const Model& model, const glm::dvec3& p, double radius) {
    for (int a = 0; a < 3; ++a)
      if (p[a] < model.low[a] - radius || p[a] > model.high[a] + radius) return false;
    if (model.wall.is_inside(p)) return true;
    constexpr int k_points = 300;
    for (int i = 0; radius > 0 && i < k_points; ++i) {  // evenly spread, on a spiral
      const double z = 1 - (2 * i + 1.0) / k_points, turn = 2.399963229728653 * i,
                   flat = std::sqrt(1 - z * z);
      if (model.wall.is_inside(p +
                               0.999 * radius * glm::dvec3(flat * std::cos(turn), flat * std::sin(turn), z)))
        return true;
    }
    return false;
  }
  void update_scene(const haptics::TouchScene& scene) {
    uncut_.clear();
    models_.clear();
    for (std::size_t i = base_shapes(scene).size(); i < scene.items.size(); ++i) {
      const haptics::TouchItem& item = scene.items[i];
      if (!item.is_mesh()) {
        haptics::TouchScene item_scene;
        for (const auto& other : scene.others)
          if (other.get() == &item.field.volume()) item_scene.base = other;
        item_scene.items = {item};
        item_scene.tool = scene.tool;
        uncut_.push_back({i, item_scene.base, scenes::GuaranteedSolid(method(), item_scene)});
        continue;
      }
      if (item.depth) continue;  // the item's triangles change over time; DepthImageJudge judges the item
      const glm::dvec3 size = item.tree->high() - item.tree->low();
      models_.push_back({i,
                         verify::MeshWall(item.tree->vertices(), item.tree->triangles(),
                                          std::max({size.x, size.y, size.z, 1e-3}) / 32),
                         item.tree->low(), item.tree->high()});
    }
  }

  std::shared_ptr<const haptics::ServoHand> servo_hand_;
  std::vector<scenes::GuaranteedSolid> cut_;  ///< of the anatomy's shapes
  std::vector<Uncut> uncut_;
  std::vector<Model> models_;
};

/// Judges of one hand, and the shape that the hand popped through.
struct AuditedHand {
  explicit AuditedHand(const verify::ForceLaw& law)
      : falls([this](const glm::dvec3& a, const glm::dvec3& b) { return solids.meets(a, b, popped_shape); }),
        force(law) {}
  AuditedHand(const AuditedHand&) = delete;
  AuditedHand& operator=(const AuditedHand&) = delete;

  TouchableSolids solids;
  verify::FallThroughJudge falls;
  verify::ForceJudge force;
  DepthImageJudge depth_images;
  FrictionAudit friction;
  std::optional<BallAudit> ball;  ///< for round tools, by a method that touches the smooth solid
  std::shared_ptr<const haptics::TouchScene> scene;
  std::shared_ptr<const haptics::LawSet> laws;
  int popped_shape = -1;
  double rearm = 0;
  glm::dvec3 popped_at{0.0};

  /// Updates pop-through: a shape that is pressed harder than its pop force lets the proxy pass, until the
  /// hand is `rearm` (mm) away from the position at which it popped through.
  void update_pop_through(const haptics::TouchScene& scene, const haptics::ServoRecord& r) {
    const glm::dvec3& at = r.pose.position_world;
    if (popped_shape >= 0) {
      if (glm::length(at - popped_at) < rearm) return;
      popped_shape = -1;
      falls.restart();  // the proxy may be inside
      return;
    }
    if (!r.has_contact || r.is_escaping) return;
    const haptics::Material& material = touched_material(scene, r);
    const double pressed = stiffness_at(scene, r) * glm::dot(r.proxy_world - at, r.normal_world);
    if (!(material.pop_force > 0) || !(pressed > material.pop_force)) return;
    popped_shape = r.shape;
    rearm = material.pop_rearm;
    popped_at = at;
  }
};

}  // namespace trephine::cli
