// TouchableSolids: the solids that one hand of a session touches, for judges.
#pragma once

#include <algorithm>
#include <cmath>
#include <memory>
#include <vector>

#include "apps/bench/scenes/guaranteed_solid.h"
#include "apps/verify/mesh_judge.h"
#include "haptics/mesh/mesh_tree.h"
#include "haptics/methods/methods.h"
#include "haptics/servo/servo_scene.h"

namespace trephine::cli {

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
  /// True if the front of an item blocks this hand. `popped`: the item that the proxy passes through; -1 if
  /// no item.
  bool blocks(std::size_t item, int popped) const {
    return haptics::blocks(servo_hand_->scene->items[item].sides, haptics::Side::front) &&
           !(servo_hand_->untouchable | servo_hand_->passable_items).contains(static_cast<int>(item)) &&
           popped != static_cast<int>(item);
  }
  /// True if a position (world) is in a model whose front blocks this hand.
  bool is_in_model(const glm::dvec3& at, int popped) const {
    return std::any_of(models_.begin(), models_.end(), [&](const Model& model) {
      return blocks(model.item, popped) &&
             is_in(model, placement(servo_hand_->scene->items[model.item]).local_from_world(at), 0);
    });
  }
  /// True if a position (world) is in a shape of a further scan whose front blocks this hand. Requires a tool
  /// without balls.
  bool is_in_further_scan(const glm::dvec3& at, int popped) const {
    return std::any_of(uncut_.begin(), uncut_.end(), [&](const Uncut& uncut) {
      const glm::dvec3 p = uncut.volume->frame.volume_from_world(at);
      return blocks(uncut.item, popped) && uncut.solid.meets(p, p);
    });
  }
  bool has_further_scans() const noexcept { return !uncut_.empty(); }
  /// True if the segment from a to b (volume frame of the anatomy), or the point if both are equal, meets a
  /// solid whose front blocks this hand. `popped`: the item that the proxy passes through; -1 if no item.
  /// `ignores_movers`: models that move are not tested.
  bool meets(const glm::dvec3& a, const glm::dvec3& b, int popped, bool ignores_movers = false) const {
    const haptics::TouchScene& scene = *servo_hand_->scene;
    for (std::size_t s = 0; s < cut_.size(); ++s)
      if (blocks(s, popped) && cut_[s].meets(a, b)) return true;
    const glm::dvec3 from = scene.base->frame.world_from_volume(a),
                     to = scene.base->frame.world_from_volume(b);
    for (const Uncut& uncut : uncut_) {
      const volume::Frame& frame = uncut.volume->frame;
      if (blocks(uncut.item, popped) &&
          uncut.solid.meets(frame.volume_from_world(from), frame.volume_from_world(to)))
        return true;
    }
    for (const Model& model : models_) {
      const haptics::TouchItem& item = scene.items[model.item];
      if (!blocks(model.item, popped) || (ignores_movers && item.mover >= 0)) continue;
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

}  // namespace trephine::cli
