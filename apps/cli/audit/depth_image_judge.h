// DepthImageJudge: judges the touch of objects by depth images.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <map>

#include "apps/verify/depth_image_judge.h"
#include "haptics/depth/depth_model.h"
#include "haptics/depth/depth_stream.h"
#include "haptics/servo/servo_scene.h"

namespace trephine::cli {

/// Judges how deep a proxy is in objects touched by depth images. The judge uses data that are independent of
/// the contact method: for a model its triangles at that time, for a depth stream the pixels around the
/// proxy.
class DepthImageJudge {
 public:
  static constexpr std::uint64_t k_every = 5;  ///< ticks between judgements

  long judged = 0, too_deep = 0;
  long passable = 0;                ///< ticks in matter that was entered where no images held the proxy
  double deepest = 0, allowed = 0;  ///< mm
  /// True if images held the proxy outside at least one object at the previous judgement. The next judgement
  /// tests the depth of the proxy only in such objects.
  bool is_free() const noexcept {
    return std::any_of(histories_.begin(), histories_.end(),
                       [](const History& item) { return item.was_free; });
  }
  /// Resets the history: the next proxy is not a continuation of the previous one.
  void restart() noexcept { histories_ = {}; }

  /// Judges the hand's proxy at `p` (world, mm). `popped`: the item that the proxy passes through after
  /// pop-through; -1 if no item.
  void judge(const haptics::ServoHand& servo_hand, const glm::dvec3& p, double time, int popped) {
    std::size_t d = 0;
    for (std::size_t i = 0; i < servo_hand.scene->items.size(); ++i) {
      const haptics::TouchItem& item = servo_hand.scene->items[i];
      if (!item.depth) continue;
      const haptics::depth::DepthSet* set = haptics::depth::set_in(servo_hand.state, static_cast<int>(d));
      History& history = histories_[d++];
      if ((servo_hand.untouchable | servo_hand.passable_items).contains(static_cast<int>(i)) ||
          popped == static_cast<int>(i)) {
        history = {};
        continue;
      }
      const auto mover = static_cast<std::size_t>(item.mover);
      const haptics::Placement placement = item.mover >= 0 && mover < servo_hand.placement_count
                                               ? servo_hand.placements[mover]
                                               : item.placement;
      const glm::dvec3 proxy_local = placement.local_from_world(p);
      const bool is_known = set &&
                            (!set->has_successor || time <= set->view.time + set->view.interval +
                                                                haptics::depth::k_extrapolation_time) &&
                            set->is_known_around(set->displacement_at(time).local_from_world(proxy_local),
                                                 servo_hand.scene->tool->radius());
      // Skip the triangles of distant objects.
      glm::dvec3 low, high;
      item.depth->bounds(low, high);
      const double distance = glm::length(proxy_local - glm::clamp(proxy_local, low, high));
      const double inside = low.x > high.x ? std::nan("")
                            : distance > 1 ? -distance
                                           : depth(item, proxy_local, time);
      if (std::isnan(inside)) {  // the depth is unknown
        history.was_free = false;
        continue;
      }
      const double tolerance = item.depth_pixel + 0.3 + (set ? 2 * (set->slack + set->slack_before) : 0);
      if (is_known && history.was_free) {
        ++judged;
        too_deep += inside > tolerance;
        deepest = std::max(deepest, inside), allowed = std::max(allowed, tolerance);
      } else if (history.has_been_free) {
        passable += inside > tolerance;
      }
      history.was_free = is_known && (inside <= 0 || (history.was_free && inside <= tolerance));
      history.has_been_free = history.has_been_free || inside <= 0;
    }
  }

 private:
  double depth(const haptics::TouchItem& item, const glm::dvec3& p, double time) {
    if (const auto* stream = dynamic_cast<const haptics::depth::DepthStream*>(item.depth.get())) {
      const haptics::depth::DepthCamera& c = stream->pictures().camera;
      if (!(p.z > 0)) return std::nan("");
      const auto column = static_cast<int>(std::floor(c.fx * p.x / p.z + c.cx)),
                 row = static_cast<int>(std::floor(c.fy * p.y / p.z + c.cy));
      double depths[4];
      for (int k = 0; k < 4; ++k) depths[k] = stream->depth_at(column + k % 2, row + k / 2, time);
      return verify::behind_pixels(depths, p.z);
    }
    const auto* model = dynamic_cast<const haptics::depth::DepthModel*>(item.depth.get());
    if (model == nullptr) return std::nan("");
    auto found = models_.find(model);
    if (found == models_.end())
      found = models_
                  .emplace(model, verify::MovingModel(
                                      model->keys().keys, model->keys().triangles, model->keys().beat,
                                      model->keys().after == haptics::depth::ModelKeys::After::repeat))
                  .first;
    return found->second.depth(p, time);
  }

  std::map<const haptics::depth::DepthModel*, verify::MovingModel> models_;
  struct History {
    bool was_free = false;       ///< outside the object and held by images, at the previous judgement
    bool has_been_free = false;  ///< outside the object at any judgement since the last restart
  };
  std::array<History, haptics::TouchScene::k_max_depths> histories_{};
};

}  // namespace trephine::cli
