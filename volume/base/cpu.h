// Use of the CPU: instruction sets and threads.
#pragma once

namespace trephine {

/// Returns true if code for AVX2 is used: if the CPU supports it, unless the environment variable
/// TREPHINE_AVX2 is "off". Results are the same bits with and without AVX2.
bool uses_avx2() noexcept;

/// Returns the number of threads that a call may use: `requested`, or if this is 0, the value of the
/// environment variable TREPHINE_THREADS (1 to 256), or by default all cores.
int thread_count(int requested) noexcept;

}  // namespace trephine
