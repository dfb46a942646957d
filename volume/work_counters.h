// Counts of what this process has made, so that reports can prove what a scene did not need.
#pragma once

#include <atomic>

namespace trephine::volume {

/// Process-wide on purpose, against the house rule: it must be shown that a mesh was never made anywhere
/// or a GL context, and a counter that is passed along cannot show that. Nothing reads them but reports.
struct WorkCounters {
  std::atomic<long> surfaces{0};       ///< whole surfaces and chunks extracted
  std::atomic<long> occupancies{0};    ///< bit fields made, one a shape
  std::atomic<long> offset_fields{0};  ///< for tools with a radius, updates included
  std::atomic<long> gl_contexts{0};    ///< windows and pictures begun
};

inline WorkCounters& work_counters() noexcept {
  static constinit WorkCounters counters;
  return counters;
}

}  // namespace trephine::volume
