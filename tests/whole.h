// Whether a test shall try all of its cases: ./test.sh --all says so, since that takes longer.
#pragma once

#include <cstdlib>

namespace trephine {

inline bool is_whole() { return std::getenv("TREPHINE_WHOLE") != nullptr; }

/// Others take twenty times as long a step.
#if defined(NDEBUG) && !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
inline constexpr bool k_is_fast_build = true;
#else
inline constexpr bool k_is_fast_build = false;
#endif

}  // namespace trephine
