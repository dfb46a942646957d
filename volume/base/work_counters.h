// WorkCounters: counts of expensive objects built by this process. A count of 0 proves that the process built
// no such object.
#pragma once

#include <atomic>

namespace trephine {

/// The counters are global on purpose, which is an exception to the rules of this project: only a global
/// counter can prove that no mesh and no GL context was created anywhere. Only reports read them.
struct WorkCounters {
  std::atomic<long> surfaces{0};       ///< whole surfaces and chunks extracted
  std::atomic<long> occupancies{0};    ///< bit fields built, one per shape
  std::atomic<long> offset_fields{0};  ///< fields for tools with a radius, updates included
  std::atomic<long> gl_contexts{0};    ///< windows and off-screen images created
};

inline WorkCounters& work_counters() noexcept {
  static constinit WorkCounters counters;
  return counters;
}

}  // namespace trephine
