// HandTrail: past positions of a hand's proxy, which give the escape path out of restored matter.
#pragma once

#include <optional>
#include <span>

#include "haptics/servo/servo_core.h"

namespace trephine::sim {

/// Positions in the base's volume frame, oldest first; each is at least half a voxel from the next. Copies
/// share the older positions.
class HandTrail {
 public:
  void add(const haptics::ServoHand& hand, const haptics::ServoRecord& tick);
  /// Returns the newest position that is free in the hand's current scene; null if all are solid.
  const glm::dvec3* last_free(const haptics::ServoHand& hand) const noexcept;
  /// Returns the path from the newest position back to the newest free position, without loops; empty if all
  /// positions are solid.
  std::optional<haptics::EscapePath> escape_path(const haptics::ServoHand& hand) const;

  /// Number of positions added so far; those from first() on are still stored.
  std::size_t count() const noexcept { return first_ + size(); }
  std::size_t first() const noexcept { return first_; }
  /// Returns the i-th position ever added; requires i >= first().
  const glm::dvec3& position(std::size_t i) const noexcept { return at(i - first_); }
  /// Restores a saved trail: the positions from `first` on.
  static HandTrail of(std::size_t first, std::span<const glm::dvec3> places);

 private:
  static constexpr std::size_t k_chunk = 128, k_max_chunks = 32;
  using Chunk = std::array<glm::dvec3, k_chunk>;
  std::size_t size() const noexcept { return k_chunk * full_.size() + newest_.size(); }
  const glm::dvec3& at(std::size_t i) const noexcept {
    return i / k_chunk < full_.size() ? (*full_[i / k_chunk])[i % k_chunk] : newest_[i % k_chunk];
  }
  void add(const glm::dvec3& position);
  std::size_t newest_free(const haptics::ServoHand& hand) const noexcept;

  std::vector<std::shared_ptr<const Chunk>> full_;
  std::vector<glm::dvec3> newest_;
  std::size_t first_ = 0;
};

}  // namespace trephine::sim
