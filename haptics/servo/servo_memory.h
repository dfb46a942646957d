// ServoMemory: state of a servo core as bytes, so that a recorded operation can be opened in its middle.
#pragma once

#include <string>
#include <string_view>

#include "haptics/servo/servo_core.h"

namespace trephine::haptics {

struct ServoMemory {
  /// `hand`: the scene of the core's last step.
  static std::string save(const ServoCore& core, const ServoHand& hand);
  /// Loads into a core with the same options, hand and period. Returns false, with the core unchanged, if the
  /// bytes are broken or refer to items that `hand` does not have.
  static bool load(std::string_view bytes, const ServoHand& hand, ServoCore& core);
};

/// Write and read the complete record of a tick, exactly.
void put_record(std::string& out, const ServoRecord& record);
bool get_record(std::string_view& in, ServoRecord& record);

}  // namespace trephine::haptics
