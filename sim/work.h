// What instruments and modules may do to an operation, and nothing beside it.
#pragma once

#include "sim/event.h"
#include "volume/removal.h"

namespace trephine::sim {

/// Handed out by the engine for one tick or one command.
class Work {
 public:
  Work(volume::RemovalEditor& editor, std::vector<Event>& events, std::uint64_t tick, std::uint8_t hand)
      : editor_(&editor), events_(&events), tick_(tick), hand_(hand) {}

  /// Takes away what a ball sweeps. Felt and seen from the next tick on.
  volume::RemovalReport remove(const volume::Sweep& sweep);
  /// The same of a body of revolution that turns on the way.
  volume::RemovalReport remove(const volume::ToolSweep& sweep);

  /// What is left, with all that was removed up to here.
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
