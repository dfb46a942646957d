#include "apps/workbench/session_summary.h"

#include <algorithm>

#include "modules/catalogue.h"

namespace trephine::workbench {

int SessionSummary::hand_at(std::uint64_t tick) const noexcept {
  if (active.empty()) return 0;
  const auto next = std::upper_bound(active.begin(), active.end(), tick,
                                     [](std::uint64_t at, const Active& one) { return at < one.tick; });
  return (next == active.begin() ? next : next - 1)->hand;
}

Result<SessionSummary> summarize_session(const std::string& file) {
  Result<sim::SessionReader> opened = sim::SessionReader::open(file, modules::catalogue());
  if (!opened) return opened.error();
  sim::SessionReader& session = opened.value();
  const double rate = session.header().rate_hz;
  SessionSummary summary;
  std::vector<bool> was_pressed(session.header().hands.size(), false);
  glm::dvec3 sum(0);
  double count = 0;
  for (sim::LogItem item;;) {
    const Result<bool> read = session.next(item);
    if (!read) return read.error();
    if (!read.value()) break;
    if (const auto* tick = std::get_if<sim::TickItem>(&item)) {
      const haptics::ServoRecord& r = tick->record;
      if (r.hand >= was_pressed.size()) continue;
      const bool is_pressed = r.pose.is_pressed();
      if (is_pressed && !was_pressed[r.hand]) summary.active.push_back({r.tick, r.hand});
      was_pressed[r.hand] = is_pressed;
      if (is_pressed) sum += r.pose.position_world, count += 1;
    } else if (const auto* event = std::get_if<sim::EventItem>(&item)) {
      EventText text = describe_event(event->event, session.header().plan.procedure);
      summary.marks.push_back(
          {static_cast<double>(event->event.tick) / rate, text.level, std::move(text.text)});
    }
  }
  std::stable_sort(summary.marks.begin(), summary.marks.end(),
                   [](const auto& a, const auto& b) { return a.seconds < b.seconds; });
  if (count > 0) summary.work_position = sum / count;
  return summary;
}

}  // namespace trephine::workbench
