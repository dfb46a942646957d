// ServoMemory: state of a servo core as bytes, so that a recorded operation can be opened at a checkpoint.
#pragma once

#include <string>
#include <string_view>

#include "haptics/servo/servo_core.h"

namespace trephine::haptics {

struct ServoMemory {
  /// `hand`: touchable data of the core's hand in the current scene.
  static std::string save(const ServoCore& core, const ServoHand& hand);
  /// Loads the state into a core with the options, the hand and the period of the saved core. Returns false,
  /// with the core unchanged, if the bytes are invalid or refer to items that `hand` does not have.
  static bool load(std::string_view bytes, const ServoHand& hand, ServoCore& core);
};

/// Appends the complete record of a tick, without loss.
void put_record(std::string& out, const ServoRecord& record);
/// Reads a record and removes it from `in`. Returns false if the bytes are invalid.
bool get_record(std::string_view& in, ServoRecord& record);

}  // namespace trephine::haptics
