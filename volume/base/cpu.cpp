#include "volume/base/cpu.h"

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <thread>

namespace trephine {

bool uses_avx2() noexcept {
  static const bool uses = [] {
    const char* const setting = std::getenv("TREPHINE_AVX2");
    return __builtin_cpu_supports("avx2") && !(setting && std::strcmp(setting, "off") == 0);
  }();
  return uses;
}

int thread_count(int requested) noexcept {
  constexpr int k_most = 256;
  static const int usual = [] {
    const char* const setting = std::getenv("TREPHINE_THREADS");
    const int threads = setting ? std::atoi(setting) : 0;
    return threads >= 1 && threads <= k_most
               ? threads
               : std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  }();
  return requested > 0 ? requested : usual;
}

}  // namespace trephine
