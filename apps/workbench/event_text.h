// Events of a session as sentences for people, and how a window shows them.
#pragma once

#include <string>

#include "sim/event.h"

namespace trephine::workbench {

/// Importance of an event in a window.
enum class EventLevel {
  record,   ///< in the log only: another part of the window shows it already
  outcome,  ///< at the tool: what an action led to
  refusal,  ///< at the tool: why nothing was done, and what to do
  danger,   ///< at the tool, in red: an injury or a fault
};

struct EventText {
  std::string text;
  EventLevel level = EventLevel::record;
};

/// Describes an event: "Bone flap of 27.0 cm2 cut, 9000 mm3; the saw removed 800 mm3". An event of a type
/// without a sentence of its own is described by its name and fields, at level `record`.
EventText describe_event(const sim::Event& event);
/// Returns whether events of this type have a sentence of their own.
bool has_event_text(const sim::ValueType& type);

}  // namespace trephine::workbench
