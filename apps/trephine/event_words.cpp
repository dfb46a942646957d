#include "apps/trephine/event_words.h"

#include "apps/workbench/text.h"
#include "sim/forbidden.h"

namespace trephine::app {

using workbench::format_text;

std::string words_of(const sim::Event& event) {
  if (const auto* fault = event.what.as<sim::FaultEvent>())
    return fault->is_cleared ? "faults cleared" : "fault: " + fault->names;
  if (const auto* entered = event.what.as<sim::ForbiddenEntered>())
    return "the tool came into " + entered->structure + (entered->is_working ? ", working" : "");
  if (const auto* left = event.what.as<sim::ForbiddenLeft>())
    return format_text("the tool left %s after %.2f s, %.2f mm deep at most", left->structure.c_str(),
                       left->seconds, left->deepest);
  const std::string words = event.what.words();
  return std::string(event.what.name()) + (words.empty() ? "" : " " + words);
}

}  // namespace trephine::app
