// State of a servo core as bytes: so a recorded operation is opened in its middle.
#pragma once

#include <string>
#include <string_view>

#include "haptics/servo/servo_core.h"

namespace trephine::haptics {

struct ServoMemory {
  /// `mine`: the scene of the core's last step.
  static std::string save(const ServoCore& core, const ServoHand& mine);
  /// Into a core of the same options, hand and period. False, and the core is as it was, when the bytes are
  /// broken, or speak of what `mine` does not have.
  static bool load(std::string_view bytes, const ServoHand& mine, ServoCore& core);
};

/// All of a tick's record, exact.
void put_record(std::string& out, const ServoRecord& record);
bool get_record(std::string_view& in, ServoRecord& record);

}  // namespace trephine::haptics
