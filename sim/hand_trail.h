// Where a hand's proxy has been: the way back out of matter that grows over it.
#pragma once

#include "haptics/servo/servo_core.h"

namespace trephine::sim {

/// Places in the base's volume frame, thinned out, oldest first.
class HandTrail {
 public:
  void note(const haptics::ServoHand& hand, const haptics::ServoRecord& tick);
  /// The newest of them that is free in what the hand feels now; null when none is.
  const glm::dvec3* last_free(const haptics::ServoHand& hand) const noexcept;
  /// From the newest back to the newest free one, loops left out. Nothing when none is free.
  std::optional<haptics::WayOut> way_out(const haptics::ServoHand& hand) const;

 private:
  std::vector<glm::dvec3> places_;
};

}  // namespace trephine::sim
