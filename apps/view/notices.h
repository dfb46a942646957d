// Notices: messages that a window shows at the tool for some seconds and keeps in a log.
#pragma once

#include <cstddef>
#include <deque>
#include <string>

#include "apps/workbench/event_text.h"

namespace trephine::view {

/// Messages about events. Times are in seconds since the window opened; in a replay, since the start of the
/// session. Not thread-safe.
class Notices {
 public:
  static constexpr double k_outcome_seconds = 5, k_refusal_seconds = 6, k_danger_seconds = 8;
  static constexpr std::size_t k_max_shown = 3, k_max_logged = 2000;

  struct Entry {
    double time = 0;          ///< time of adding, s
    double session_time = 0;  ///< time in the session, s
    workbench::EventLevel level = workbench::EventLevel::record;
    std::string text;
  };

  void add(Entry entry);
  /// Ends the display of the outcomes and refusals that were added until `now`, such as those of an undone
  /// change. Dangers are still shown for k_danger_seconds.
  void dismiss(double now) noexcept { dismissed_ = now > dismissed_ ? now : dismissed_; }
  /// Returns the newest messages to show at the tool, at most k_max_shown, one per line, newest last. Equal
  /// messages are merged.
  std::string shown(double now) const;
  /// Returns the most urgent level of the messages of shown(); EventLevel::record if there are no messages.
  workbench::EventLevel shown_level(double now) const;
  const std::deque<Entry>& log() const noexcept { return log_; }
  /// Returns the number of entries added so far, including those that the log no longer keeps.
  std::size_t count() const noexcept { return count_; }

 private:
  template <class Visit>
  void visit_shown(double now, const Visit& visit) const;
  std::deque<Entry> log_;
  std::size_t count_ = 0;
  double dismissed_ = -1;  ///< s, time of the last dismiss()
};

}  // namespace trephine::view
