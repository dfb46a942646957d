#include "sim/session/compression.h"

#include <zstd.h>

#include "volume/base/bytes.h"

namespace trephine::sim {

std::string compress(std::string_view bytes) {
  std::string out;
  put_number(out, static_cast<std::int64_t>(bytes.size()));
  const std::size_t head = out.size(), bound = ::ZSTD_compressBound(bytes.size());
  out.resize(head + bound);
  constexpr int k_level = 6;
  // Fails only if an allocation fails.
  const std::size_t length = ::ZSTD_compress(out.data() + head, bound, bytes.data(), bytes.size(), k_level);
  TREPHINE_ASSERT(!::ZSTD_isError(length));
  out.resize(head + length);
  return out;
}

Result<std::string> decompress(std::string_view bytes) {
  const Error broken{.what = "the compressed data of the session are damaged",
                     .expected = "data as trephine wrote them",
                     .remedy = "use an undamaged copy of the session"};
  std::int64_t length = 0;
  // Limits the allocation. The length must equal that in the header of the zstd frame, so that a wrong length
  // allocates nothing.
  constexpr std::int64_t k_longest = std::int64_t{1} << 28;
  if (!get_number(bytes, length) || length < 0 || length > k_longest ||
      ::ZSTD_getFrameContentSize(bytes.data(), bytes.size()) != static_cast<unsigned long long>(length))
    return broken;
  std::string out(static_cast<std::size_t>(length), '\0');
  const std::size_t result = ::ZSTD_decompress(out.data(), out.size(), bytes.data(), bytes.size());
  if (::ZSTD_isError(result) || result != out.size()) return broken;
  return out;
}

}  // namespace trephine::sim
