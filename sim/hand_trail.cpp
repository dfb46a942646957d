#include "sim/hand_trail.h"

#include <glm/geometric.hpp>

#include "haptics/walls/free_place.h"

namespace trephine::sim {

/// Keeps places farther than half a voxel from the last one; when there are too many the older half is
/// dropped.
void HandTrail::note(const haptics::ServoHand& hand, const haptics::ServoRecord& tick) {
  if (tick.is_led || tick.is_buried || (tick.faults & haptics::k_latched_faults) != 0) return;
  constexpr std::size_t k_most = 4096;
  const glm::dvec3 place = hand.scene->base->frame.volume_from_world(tick.proxy_world);
  if (!places_.empty() && glm::length(places_.back() - place) < 0.5) return;
  if (places_.size() >= k_most) places_.erase(places_.begin(), places_.begin() + k_most / 2);
  places_.push_back(place);
}

const glm::dvec3* HandTrail::last_free(const haptics::ServoHand& hand) const noexcept {
  for (std::size_t i = places_.size(); i-- > 0;)
    if (haptics::is_free(*hand.scene, hand.state, places_[i])) return &places_[i];
  return nullptr;
}

std::optional<haptics::WayOut> HandTrail::way_out(const haptics::ServoHand& hand) const {
  const glm::dvec3* free = last_free(hand);
  if (free == nullptr) return std::nullopt;
  // Back along the path; from each place straight on to the oldest one that lies beside it.
  constexpr double k_beside = 1;  // voxels
  const auto last = static_cast<std::size_t>(free - places_.data());
  std::vector<glm::dvec3> way;
  for (std::size_t i = places_.size() - 1;;) {
    way.push_back(places_[i]);
    if (i == last) break;
    std::size_t next = last;
    while (next + 1 < i && glm::length(places_[next] - places_[i]) > k_beside) ++next;
    i = next;
  }
  haptics::WayOut result;
  const std::size_t stride =
      (way.size() + haptics::WayOut::k_most_places - 1) / haptics::WayOut::k_most_places;
  for (std::size_t i = stride - 1; i < way.size(); i += stride) result.places_volume[result.count++] = way[i];
  if (way.size() % stride != 0) {
    if (result.count == haptics::WayOut::k_most_places) --result.count;
    result.places_volume[result.count++] = way.back();
  }
  return result;
}

}  // namespace trephine::sim
