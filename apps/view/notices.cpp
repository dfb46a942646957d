#include "apps/view/notices.h"

#include <algorithm>
#include <iterator>
#include <utility>
#include <vector>

namespace trephine::view {

using workbench::EventLevel;

namespace {

double seconds_of(EventLevel level) noexcept {
  switch (level) {
    case EventLevel::outcome:
      return Notices::k_outcome_seconds;
    case EventLevel::refusal:
      return Notices::k_refusal_seconds;
    case EventLevel::danger:
      return Notices::k_danger_seconds;
    case EventLevel::record:
      break;
  }
  return 0;
}

}  // namespace

void Notices::add(Entry entry) {
  ++count_;
  log_.push_back(std::move(entry));
  if (log_.size() > k_max_logged) log_.pop_front();
}

template <class Visit>
void Notices::visit_shown(double now, const Visit& visit) const {
  std::vector<const Entry*> shown;
  bool has_outcome = false;
  double outcome_time = 0;
  for (auto entry = log_.rbegin(); entry != log_.rend(); ++entry) {
    if (entry->time > now) continue;  // after a replay went back
    if (now - entry->time > k_danger_seconds) break;
    if (entry->time <= dismissed_ && entry->level != EventLevel::danger) continue;
    // A refusal is not shown after a later action that succeeded, even when that outcome is no longer shown.
    if (entry->level == EventLevel::refusal && has_outcome && entry->session_time < outcome_time) continue;
    if (entry->level == EventLevel::outcome && !has_outcome)
      has_outcome = true, outcome_time = entry->session_time;
    if (now - entry->time > seconds_of(entry->level) || entry->level == EventLevel::record) continue;
    if (std::any_of(shown.begin(), shown.end(), [&](const Entry* s) { return s->text == entry->text; }))
      continue;
    // A danger replaces the oldest other message if there are too many.
    if (shown.size() == k_max_shown) {
      if (entry->level != EventLevel::danger) continue;
      const auto other = std::find_if(shown.rbegin(), shown.rend(),
                                      [](const Entry* s) { return s->level != EventLevel::danger; });
      if (other == shown.rend()) break;
      shown.erase(std::next(other).base());
    }
    shown.push_back(&*entry);
  }
  for (auto entry = shown.rbegin(); entry != shown.rend(); ++entry) visit(**entry);
}

std::string Notices::shown(double now) const {
  std::string text;
  visit_shown(now, [&](const Entry& entry) { text += (text.empty() ? "" : "\n") + entry.text; });
  return text;
}

EventLevel Notices::shown_level(double now) const {
  EventLevel level = EventLevel::record;
  visit_shown(now, [&](const Entry& entry) { level = std::max(level, entry.level); });
  return level;
}

}  // namespace trephine::view
