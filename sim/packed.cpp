#include "sim/packed.h"

#include <zstd.h>

#include "volume/bytes.h"

namespace trephine::sim {

std::string packed(std::string_view bytes) {
  std::string out;
  volume::put_number(out, static_cast<std::int64_t>(bytes.size()));
  const std::size_t head = out.size(), most = ::ZSTD_compressBound(bytes.size());
  out.resize(head + most);
  constexpr int k_level = 6;
  // It fails for want of memory alone, as an allocation does.
  const std::size_t length = ::ZSTD_compress(out.data() + head, most, bytes.data(), bytes.size(), k_level);
  TREPHINE_ASSERT(!::ZSTD_isError(length));
  out.resize(head + length);
  return out;
}

volume::Result<std::string> unpacked(std::string_view bytes) {
  const volume::Error broken{"packed bytes of the session are broken", "", "", "what trephine wrote", ""};
  std::int64_t length = 0;
  // Longer than any block's; and as long as zstd itself says, so that nothing is allocated for a lie.
  constexpr std::int64_t k_longest = std::int64_t{1} << 28;
  if (!volume::get_number(bytes, length) || length < 0 || length > k_longest ||
      ::ZSTD_getFrameContentSize(bytes.data(), bytes.size()) != static_cast<unsigned long long>(length))
    return broken;
  std::string out(static_cast<std::size_t>(length), '\0');
  const std::size_t made = ::ZSTD_decompress(out.data(), out.size(), bytes.data(), bytes.size());
  if (::ZSTD_isError(made) || made != out.size()) return broken;
  return out;
}

}  // namespace trephine::sim
