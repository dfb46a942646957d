// Events of a session as sentences for users, with their importance in a window.
#pragma once

#include <string>

#include "sim/api/event.h"
#include "volume/scan/procedure.h"

namespace trephine::workbench {

/// Importance of an event in a window.
enum class EventLevel {
  record,   ///< shown in the log only, since another part of the window displays it
  outcome,  ///< shown at the tool: result of an action
  refusal,  ///< shown at the tool: reason of a refusal, and the remedy
  danger,   ///< shown at the tool, in red: an injury or a fault
};

struct EventText {
  std::string text;
  EventLevel level = EventLevel::record;
};

/// Describes an event: "Bone flap of 27.0 cm2 cut, 9000 mm3; the saw removed 800 mm3". An event of a type
/// without a sentence of its own is described by its name and fields, at level `record`. `procedure`: of the
/// operation, for the titles of its steps.
EventText describe_event(const sim::Event& event, const volume::SurgicalProcedure& procedure = {});
/// True if events of this type have a sentence of their own.
bool has_event_text(const sim::ValueType& type);

/// Returns the reasons for which the force is off, for users: "the computer is too busy".
std::string fault_reasons(std::uint32_t faults);

}  // namespace trephine::workbench
