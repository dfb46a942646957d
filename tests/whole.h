// Whether a test shall try all of its cases: ./test.sh --all says so, since that takes longer.
#pragma once

#include <cstdlib>

namespace trephine {

inline bool is_whole() { return std::getenv("TREPHINE_WHOLE") != nullptr; }

}  // namespace trephine
