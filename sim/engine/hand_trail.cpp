#include "sim/engine/hand_trail.h"

#include <algorithm>
#include <glm/geometric.hpp>

#include "haptics/walls/free_place.h"

namespace trephine::sim {

/// Adds the proxy's position if it is at least half a voxel from the last position. Ignores ticks with a
/// latched fault or a proxy that escapes or is buried. A full trail loses its older half.
void HandTrail::add(const haptics::ServoHand& hand, const haptics::ServoRecord& tick) {
  if (tick.is_escaping || tick.is_buried || (tick.faults & haptics::k_latched_faults) != 0) return;
  const glm::dvec3 position = hand.scene->base->frame.volume_from_world(tick.proxy_world);
  if (size() > 0 && glm::length(at(size() - 1) - position) < 0.5) return;
  add(position);
}

void HandTrail::add(const glm::dvec3& position) {
  if (full_.size() == k_max_chunks) {
    full_.erase(full_.begin(), full_.begin() + k_max_chunks / 2);
    first_ += k_max_chunks / 2 * k_chunk;
  }
  newest_.push_back(position);
  if (newest_.size() < k_chunk) return;
  auto chunk = std::make_shared<Chunk>();
  std::copy(newest_.begin(), newest_.end(), chunk->begin());
  full_.push_back(std::move(chunk));
  newest_.clear();
}

HandTrail HandTrail::of(std::size_t first, std::span<const glm::dvec3> places) {
  HandTrail output;
  output.first_ = first;
  for (const glm::dvec3& position : places) output.add(position);
  return output;
}

const glm::dvec3* HandTrail::last_free(const haptics::ServoHand& hand) const noexcept {
  const std::size_t i = newest_free(hand);
  return i < size() ? &at(i) : nullptr;
}
/// Returns size() if no position is free.
std::size_t HandTrail::newest_free(const haptics::ServoHand& hand) const noexcept {
  for (std::size_t i = size(); i-- > 0;)
    if (haptics::is_free(*hand.scene, hand.state, at(i))) return i;
  return size();
}

std::optional<haptics::EscapePath> HandTrail::escape_path(const haptics::ServoHand& hand) const {
  const std::size_t last = newest_free(hand);
  if (last == size()) return std::nullopt;
  // Goes back along the trail, from each position straight to the oldest one near it.
  constexpr double k_near = 1;  // voxels
  std::vector<glm::dvec3> path;
  for (std::size_t i = size() - 1;;) {
    path.push_back(at(i));
    if (i == last) break;
    std::size_t next = last;
    while (next + 1 < i && glm::length(at(next) - at(i)) > k_near) ++next;
    i = next;
  }
  haptics::EscapePath result;
  const std::size_t stride =
      (path.size() + haptics::EscapePath::k_max_positions - 1) / haptics::EscapePath::k_max_positions;
  for (std::size_t i = stride - 1; i < path.size(); i += stride)
    result.positions_volume[result.count++] = path[i];
  if (path.size() % stride != 0) {
    if (result.count == haptics::EscapePath::k_max_positions) --result.count;
    result.positions_volume[result.count++] = path.back();
  }
  return result;
}

}  // namespace trephine::sim
