// runs_all_cases(), k_is_fast_build: extent of long tests.
#pragma once

#include <cstdlib>

namespace trephine {

/// Returns true if a test shall run all of its cases, which takes longer: ./test.sh --all sets
/// TREPHINE_WHOLE.
inline bool runs_all_cases() { return std::getenv("TREPHINE_WHOLE") != nullptr; }

/// True for optimized builds without sanitizers; other builds take up to twenty times as long per step.
#if defined(NDEBUG) && !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
inline constexpr bool k_is_fast_build = true;
#else
inline constexpr bool k_is_fast_build = false;
#endif

}  // namespace trephine
