#include "volume/base/buffer.h"

#include <cstdlib>
#include <new>
#include <sys/mman.h>

namespace trephine {

void* allocate_pages(std::size_t bytes) {
  constexpr std::size_t k_huge_page = 2 << 20;
  if (bytes < 2 * k_huge_page) {
    void* memory = std::malloc(bytes > 0 ? bytes : 1);
    if (memory == nullptr) throw std::bad_alloc();
    return memory;
  }
  const std::size_t rounded = (bytes + k_huge_page - 1) / k_huge_page * k_huge_page;
  void* memory = std::aligned_alloc(k_huge_page, rounded);
  if (memory == nullptr) throw std::bad_alloc();
  madvise(memory, rounded, MADV_HUGEPAGE);  // only a request: refusal affects nothing but speed
  return memory;
}

}  // namespace trephine
