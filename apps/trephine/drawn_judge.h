// Judges what an operation felt by depth images.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "haptics/depth/depth_model.h"
#include "haptics/depth/depth_stream.h"
#include "haptics/servo/servo_scene.h"
#include "tests/checker/drawn_judge.h"

namespace trephine::app {

/// What is felt by depth images, by other means: its own triangles at that time, or the pixels around.
class DrawnJudge {
 public:
  static constexpr std::uint64_t k_every = 5;  ///< ticks

  long judged = 0, sunk = 0;
  double deepest = 0, allowed = 0;  ///< mm
  /// Was the proxy free of all that is near? Else the next tick is not judged.
  bool is_free() const noexcept {
    return std::any_of(was_free_.begin(), was_free_.end(), [](bool was) { return was; });
  }

  /// `p`: where the hand's proxy is, world.
  void judge(const haptics::ServoHand& felt, const glm::dvec3& p, double time) {
    std::size_t d = 0;
    for (std::size_t i = 0; i < felt.scene->items.size(); ++i) {
      const haptics::TouchItem& item = felt.scene->items[i];
      if (!item.depth) continue;
      const haptics::depth::DepthSet* set = haptics::depth::set_in(felt.state, static_cast<int>(d));
      bool& was_free = was_free_[d++];
      const auto mover = static_cast<std::size_t>(item.mover);
      const haptics::Placement place =
          item.mover >= 0 && mover < felt.placement_count ? felt.placements[mover] : item.placement;
      const glm::dvec3 at = place.local_from_world(p);
      const bool is_known =
          set && !felt.untouchable.contains(static_cast<int>(i)) &&
          (!set->goes_on || time <= set->view.time + set->view.interval + haptics::depth::k_foretold) &&
          set->knows(set->place_at(time).local_from_world(at), felt.scene->tool_radius);
      if (!is_known) {
        was_free = false;
        continue;
      }
      const double within = depth(item, at, time);
      if (std::isnan(within)) {  // nobody knows
        was_free = false;
        continue;
      }
      const double may = item.depth_pixel + 0.3 + 2 * (set->slack + set->slack_before);
      if (was_free) {
        ++judged;
        sunk += within > may;
        deepest = std::max(deepest, within), allowed = std::max(allowed, may);
      }
      was_free = within <= 0 || (was_free && within <= may);
    }
  }

 private:
  double depth(const haptics::TouchItem& item, const glm::dvec3& p, double time) {
    if (const auto* stream = dynamic_cast<const haptics::depth::DepthStream*>(item.depth.get())) {
      const haptics::depth::DepthCamera& c = stream->pictures().camera;
      if (!(p.z > 0)) return std::nan("");
      const auto column = static_cast<int>(std::floor(c.fx * p.x / p.z + c.cx)),
                 row = static_cast<int>(std::floor(c.fy * p.y / p.z + c.cy));
      double around[4];
      for (int k = 0; k < 4; ++k) around[k] = stream->depth_at(column + k % 2, row + k / 2, time);
      return checker::behind_pixels(around, p.z);
    }
    const auto* model = dynamic_cast<const haptics::depth::DepthModel*>(item.depth.get());
    if (model == nullptr) return std::nan("");
    auto found = models_.find(model);
    if (found == models_.end())
      found = models_
                  .emplace(model, checker::MovingModel(
                                      model->keys().keys, model->keys().triangles, model->keys().beat,
                                      model->keys().after == haptics::depth::ModelKeys::After::repeat))
                  .first;
    return found->second.depth(p, time);
  }

  std::map<const haptics::depth::DepthModel*, checker::MovingModel> models_;
  std::array<bool, haptics::TouchScene::k_max_depths> was_free_{};
};

}  // namespace trephine::app
