#include "haptics/servo/readiness.h"

#include <algorithm>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "haptics/depth/depth_source.h"

namespace trephine::haptics {

using glm::dvec3;

namespace {

/// Returns true if a partly available item is ready to stop the tool: its available part contains the
/// surroundings of hand and proxy, or these are outside the volume. `farthest`: mm, extent of the tool.
bool is_part_ready(const ServoHand& hand, const ServoHand::Part& part, const ReadinessQuery& query,
                   double farthest) noexcept {
  const TouchItem& item = item_of(*hand.scene, part.item);
  const volume::Volume& scan = item.is_mesh() ? *hand.scene->base : item.field.volume();
  const dvec3 tip = scan.frame.volume_from_world(query.hip_world),
              proxy = scan.frame.volume_from_world(query.proxy_world);
  bool is_within = true, is_outside = false;
  for (int a = 0; a < 3; ++a) {
    constexpr double k_margin = 3;  // voxels
    dvec3 along(0);
    along[a] = 1;
    const double reach = k_margin + farthest * glm::length(scan.frame.gradient_world_from_volume(along));
    const double low = std::max(0.0, std::min(tip[a], proxy[a]) - reach),
                 high = std::min(scan.size[a] - 1.0, std::max(tip[a], proxy[a]) + reach);
    is_outside = is_outside || low > high;
    is_within = is_within && low >= part.voxels.low[a] && high <= part.voxels.high[a];
  }
  // Beyond the volume's border no data are missing.
  return is_within || is_outside;
}

void find_depths_ready(const ServoHand& hand, const ReadinessQuery& query, double farthest,
                       Readiness& result) noexcept {
  int d = 0;
  for (int s = 0; s < item_count(*hand.scene); ++s) {
    const TouchItem& item = item_of(*hand.scene, s);
    if (!item.depth) continue;
    const depth::DepthSet* set = depth::set_in(hand.state, d++);
    Placement placement = item.placement;
    if (item.mover >= 0 && static_cast<std::size_t>(item.mover) < hand.placement_count)
      placement = hand.placements[static_cast<std::size_t>(item.mover)];
    // DepthSource::bounds() contains the object at all times, so the extrapolated motion is not applied to
    // it.
    const dvec3 hip_at_rest = placement.local_from_world(query.hip_world),
                proxy_at_rest = placement.local_from_world(query.proxy_world);
    if (set) placement = placement * set->displacement_at(query.time);
    const dvec3 hip = placement.local_from_world(query.hip_world),
                proxy = placement.local_from_world(query.proxy_world);
    const double late = set && set->has_successor ? query.time - set->view.time - set->view.interval : 0;
    const bool is_known = set && set->is_known_around(hip, farthest) &&
                          set->is_known_around(proxy, farthest) &&
                          late < depth::k_extrapolation_time + depth::k_fading;
    dvec3 low, high;
    item.depth->bounds(low, high);
    const auto is_far = [&](const dvec3& p) {
      return glm::length(p - glm::clamp(p, low, high)) > farthest + depth::k_bounds_margin;
    };
    if (!is_known && !(is_far(hip_at_rest) && is_far(proxy_at_rest))) result.not_ready.set(s, true);
    if (late > depth::k_extrapolation_time && query.touched_item == s)
      result.fade = std::max(0.0, 1 - (late - depth::k_extrapolation_time) / depth::k_fading);
  }
}

}  // namespace

Readiness readiness_of(const ServoHand& hand, const ReadinessQuery& query) noexcept {
  Readiness result{hand.not_ready};
  if (hand.part_count == 0 && hand.state.depths.empty()) return result;
  const double farthest = hand.scene->tool->extent();
  if (!hand.state.depths.empty()) find_depths_ready(hand, query, farthest, result);
  for (std::size_t i = 0; i < hand.part_count; ++i)
    result.not_ready.set(hand.parts[i].item, !is_part_ready(hand, hand.parts[i], query, farthest));
  return result;
}

}  // namespace trephine::haptics
