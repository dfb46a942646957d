#include "haptics/servo/servo_record.h"

namespace trephine::haptics {

const char* event_name(TouchEvent::Kind kind) noexcept {
  constexpr const char* k_names[] = {"touched",   "untouched", "popped",          "rearmed",
                                     "not ready", "ready",     "lost resistance", "met resistance"};
  return k_names[kind];
}

}  // namespace trephine::haptics
