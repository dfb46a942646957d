// Headless operation without threads: one servo step, then its edit, and so on. Same input, same bits.
#pragma once

#include <vector>

#include "sim/edit_session.h"

namespace trephine::sim {

class Lockstep {
 public:
  /// Borrows everything; the method was prepared for the scene. A null tool only touches.
  Lockstep(const haptics::TouchScene& scene, const haptics::ProxyMethod& method, Tool* tool,
           const haptics::ForceOptions& force, double rate_hz);

  /// One tick. The servo sees the version that the tick before left.
  haptics::ServoRecord step(const haptics::Pose& pose, double t);
  /// By stroke. A tool in contact goes back to its last recorded point that is free then, its force from
  /// zero.
  EditOutcome undo();
  EditOutcome redo();

  const EditSession& edits() const noexcept { return edits_; }
  const haptics::ProxyStep& last_step() const noexcept { return servo_.last_step(); }
  const EditOutcome& last_edit() const noexcept { return last_edit_; }

 private:
  EditOutcome after_travel(EditOutcome outcome);

  EditSession edits_;
  haptics::ServoCore servo_;
  std::vector<glm::dvec3> places_;  // where the proxy was, volume frame, thinned out
  EditOutcome last_edit_;
};

/// Keeps the proxy's way for going back: appends `place` when it is farther than half a voxel from the last
/// one; when longer than 4096 the older half is dropped.
void remember_place(std::vector<glm::dvec3>& places, const glm::dvec3& place);

}  // namespace trephine::sim
