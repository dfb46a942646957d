// Operations that instruments and modules may perform, and no others.
#pragma once

#include "sim/event.h"
#include "volume/removal.h"

namespace trephine::sim {

/// Handed out by the engine for one tick or one command.
class Work {
 public:
  Work(volume::RemovalEditor& editor, std::vector<Event>& events, std::uint64_t tick, std::uint8_t hand)
      : editor_(&editor), events_(&events), tick_(tick), hand_(hand) {}

  /// Removes what a ball sweeps. Touched and seen from the next tick on.
  volume::RemovalReport remove(const volume::Sweep& sweep);
  /// Removes what a body of revolution sweeps that turns on the way.
  volume::RemovalReport remove(const volume::ToolSweep& sweep);

  /// Remaining matter, with all removals up to here.
  const volume::Version& left() const noexcept { return editor_->working(); }
  bool is_matter(const glm::dvec3& p_world) const noexcept { return editor_->is_matter(p_world); }
  void raise_event(Value what, const glm::dvec3& place_world);

  /// All that remove() did.
  const volume::RemovalReport& removed() const noexcept { return removed_; }

 private:
  volume::RemovalEditor* editor_;
  std::vector<Event>* events_;
  std::uint64_t tick_;
  std::uint8_t hand_;
  volume::RemovalReport removed_;
};

using volume::add, volume::united;

inline constexpr volume::VoxelBox k_no_voxels{glm::ivec3(0), glm::ivec3(-1)};

}  // namespace trephine::sim
