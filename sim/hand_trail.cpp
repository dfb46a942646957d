#include "sim/hand_trail.h"

#include <algorithm>
#include <glm/geometric.hpp>

#include "haptics/walls/free_place.h"

namespace trephine::sim {

/// Keeps places farther than half a voxel from the last one; when there are too many the older half is
/// dropped.
void HandTrail::add(const haptics::ServoHand& hand, const haptics::ServoRecord& tick) {
  if (tick.is_led || tick.is_buried || (tick.faults & haptics::k_latched_faults) != 0) return;
  const glm::dvec3 place = hand.scene->base->frame.volume_from_world(tick.proxy_world);
  if (size() > 0 && glm::length(at(size() - 1) - place) < 0.5) return;
  add(place);
}

void HandTrail::add(const glm::dvec3& place) {
  if (full_.size() == k_most_chunks) {
    full_.erase(full_.begin(), full_.begin() + k_most_chunks / 2);
    first_ += k_most_chunks / 2 * k_chunk;
  }
  newest_.push_back(place);
  if (newest_.size() < k_chunk) return;
  auto chunk = std::make_shared<Chunk>();
  std::copy(newest_.begin(), newest_.end(), chunk->begin());
  full_.push_back(std::move(chunk));
  newest_.clear();
}

HandTrail HandTrail::of(std::size_t first, std::span<const glm::dvec3> places) {
  HandTrail made;
  made.first_ = first;
  for (const glm::dvec3& place : places) made.add(place);
  return made;
}

const glm::dvec3* HandTrail::last_free(const haptics::ServoHand& hand) const noexcept {
  const std::size_t i = newest_free(hand);
  return i < size() ? &at(i) : nullptr;
}
/// size(): none is.
std::size_t HandTrail::newest_free(const haptics::ServoHand& hand) const noexcept {
  for (std::size_t i = size(); i-- > 0;)
    if (haptics::is_free(*hand.scene, hand.state, at(i))) return i;
  return size();
}

std::optional<haptics::WayOut> HandTrail::way_out(const haptics::ServoHand& hand) const {
  const std::size_t last = newest_free(hand);
  if (last == size()) return std::nullopt;
  // Back along the path; from each place straight on to the oldest one that lies near it.
  constexpr double k_beside = 1;  // voxels
  std::vector<glm::dvec3> way;
  for (std::size_t i = size() - 1;;) {
    way.push_back(at(i));
    if (i == last) break;
    std::size_t next = last;
    while (next + 1 < i && glm::length(at(next) - at(i)) > k_beside) ++next;
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
