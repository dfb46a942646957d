// number(): reproducible pseudo-random numbers without the state of a generator.
#pragma once

#include <cstdint>

#include "volume/base/deterministic_math.h"

namespace trephine {

/// Returns a number from 0 to below 1 that depends on n alone.
inline double number(std::uint64_t n) { return static_cast<double>(hash_bits(n) >> 11) * 0x1p-53; }

}  // namespace trephine
