// Judge of touch by depth images.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <map>

#include "haptics/depth/depth_model.h"
#include "haptics/depth/depth_stream.h"
#include "haptics/servo/servo_scene.h"
#include "tests/checker/drawn_judge.h"

namespace trephine::app {

/// Judges objects touched by depth images, by other means: their own triangles at that time, or the pixels
/// around.
class DrawnJudge {
 public:
  static constexpr std::uint64_t k_every = 5;  ///< ticks

  long judged = 0, sunk = 0;
  long let_through = 0;             ///< ticks in matter that it came into where no images held it
  double deepest = 0, allowed = 0;  ///< mm
  /// Was the proxy free of all that is near? Else the next tick is not judged.
  bool is_free() const noexcept {
    return std::any_of(seen_.begin(), seen_.end(), [](const Seen& one) { return one.was_free; });
  }
  /// The next proxy did not come from the last one.
  void restart() noexcept { seen_ = {}; }

  /// `p`: where the hand's proxy is, world. `popped`: an item that gave way, as asked; -1: none.
  void judge(const haptics::ServoHand& servo_hand, const glm::dvec3& p, double time, int popped) {
    std::size_t d = 0;
    for (std::size_t i = 0; i < servo_hand.scene->items.size(); ++i) {
      const haptics::TouchItem& item = servo_hand.scene->items[i];
      if (!item.depth) continue;
      const haptics::depth::DepthSet* set = haptics::depth::set_in(servo_hand.state, static_cast<int>(d));
      Seen& seen = seen_[d++];
      if (servo_hand.untouchable.contains(static_cast<int>(i)) || popped == static_cast<int>(i)) {
        seen = {};
        continue;
      }
      const auto mover = static_cast<std::size_t>(item.mover);
      const haptics::Placement place = item.mover >= 0 && mover < servo_hand.placement_count
                                           ? servo_hand.placements[mover]
                                           : item.placement;
      const glm::dvec3 at = place.local_from_world(p);
      const bool is_known =
          set &&
          (!set->goes_on || time <= set->view.time + set->view.interval + haptics::depth::k_foretold) &&
          set->knows(set->place_at(time).local_from_world(at), servo_hand.scene->tool_radius);
      // Triangles of an object that is far away need not be asked.
      glm::dvec3 low, high;
      item.depth->bounds(low, high);
      const double far = glm::length(at - glm::clamp(at, low, high));
      const double within = low.x > high.x ? std::nan("") : far > 1 ? -far : depth(item, at, time);
      if (std::isnan(within)) {  // unknown
        seen.was_free = false;
        continue;
      }
      const double may = item.depth_pixel + 0.3 + (set ? 2 * (set->slack + set->slack_before) : 0);
      if (is_known && seen.was_free) {
        ++judged;
        sunk += within > may;
        deepest = std::max(deepest, within), allowed = std::max(allowed, may);
      } else if (seen.has_been_free) {
        let_through += within > may;
      }
      seen.was_free = is_known && (within <= 0 || (seen.was_free && within <= may));
      seen.has_been_free = seen.has_been_free || within <= 0;
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
  struct Seen {
    bool was_free = false;       ///< in the tick before, and held
    bool has_been_free = false;  ///< since it began
  };
  std::array<Seen, haptics::TouchScene::k_max_depths> seen_{};
};

}  // namespace trephine::app
