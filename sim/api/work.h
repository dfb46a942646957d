// Work: the only edits and events that instruments and modules may make.
#pragma once

#include "sim/api/event.h"
#include "volume/cuts/removal.h"

namespace trephine::sim {

/// Access to the engine for one tick or one command.
class Work {
 public:
  Work(volume::RemovalEditor& editor, std::vector<Event>& events, std::uint64_t tick, std::uint8_t hand)
      : editor_(&editor), events_(&events), tick_(tick), hand_(hand) {}

  /// Removes the matter that a ball sweeps. Hands and displays receive the change after the tick or command.
  volume::RemovalReport remove(const volume::Sweep& sweep);
  /// Removes the matter that a body of revolution sweeps while it also turns.
  volume::RemovalReport remove(const volume::ToolSweep& sweep);

  /// Remaining matter after all removals so far, including those of this tick or command.
  const volume::Version& remaining() const noexcept { return editor_->working(); }
  bool is_matter(const glm::dvec3& p_world) const noexcept { return editor_->is_matter(p_world); }
  /// Returns true if a point is solid in the scan, and was removed.
  bool is_removed_matter(const glm::dvec3& p_world) const noexcept {
    return editor_->is_removed_matter(p_world);
  }
  void raise_event(Value value, const glm::dvec3& position_world);

  /// Sum of all reports of remove().
  const volume::RemovalReport& removed() const noexcept { return removed_; }

 private:
  volume::RemovalEditor* editor_;
  std::vector<Event>* events_;
  std::uint64_t tick_;
  std::uint8_t hand_;
  volume::RemovalReport removed_;
};

using volume::add, volume::union_of;

inline constexpr volume::VoxelBox k_no_voxels{glm::ivec3(0), glm::ivec3(-1)};

}  // namespace trephine::sim
