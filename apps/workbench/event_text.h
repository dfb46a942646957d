// Events of a session as sentences for users, with their importance in a window.
#pragma once

#include <string>

#include "sim/api/event.h"
#include "volume/scan/procedure.h"

namespace trephine::workbench {

/// Importance of an event in a window.
enum class EventLevel {
  record,   ///< listed in the log only; other parts of the window may show its content
  outcome,  ///< shown at the tool: result of an action
  refusal,  ///< shown at the tool, in amber: reason of a refusal, and the remedy; a missed target
  danger,   ///< shown at the tool, in red: an injury or a fault
};

struct EventText {
  std::string text;
  EventLevel level = EventLevel::record;
};

/// Describes an event: "Bone flap of 27.0 cm2 cut, 9000 mm3; the saw removed 800 mm3". If the type of the
/// event has no sentence of its own, returns the name and the fields of the event, at level `record`.
/// `procedure`: procedure of the operation, which contains the titles of the steps.
EventText describe_event(const sim::Event& event, const volume::SurgicalProcedure& procedure = {});
/// Replaces the names of steps after the words "the step" by their titles in quotes.
std::string with_step_titles(std::string text, const volume::SurgicalProcedure& procedure);
/// True if events of this type have a sentence of their own.
bool has_event_text(const sim::ValueType& type);

/// Returns the reasons why the force is off, for users: "the computer is too busy". `faults`: fault bits of a
/// servo record. Empty if no bit is a latched fault.
std::string fault_reasons(std::uint32_t faults);

}  // namespace trephine::workbench
