#include "sim/packed.h"

#include <zlib.h>

#include "volume/bytes.h"

namespace trephine::sim {

std::string packed(std::string_view bytes, Packing how) {
  std::string out;
  volume::put_number(out, static_cast<std::int64_t>(bytes.size()));
  const std::size_t head = out.size();
  uLongf length = ::compressBound(bytes.size());
  out.resize(head + length);
  ::compress2(reinterpret_cast<Bytef*>(out.data() + head), &length,
              reinterpret_cast<const Bytef*>(bytes.data()), bytes.size(), static_cast<int>(how));
  out.resize(head + length);
  return out;
}

volume::Result<std::string> unpacked(std::string_view bytes) {
  const volume::Error broken{"packed bytes of the session are broken", "", "", "what trephine wrote", ""};
  std::int64_t length = 0;
  // Nothing deflates to less than a thousandth.
  constexpr std::int64_t k_most_to_one = 1100;
  if (!volume::get_number(bytes, length) || length < 0 ||
      length / k_most_to_one > static_cast<std::int64_t>(bytes.size()))
    return broken;
  std::string out(static_cast<std::size_t>(length), '\0');
  uLongf made = out.size();
  if (::uncompress(reinterpret_cast<Bytef*>(out.data()), &made, reinterpret_cast<const Bytef*>(bytes.data()),
                   bytes.size()) != Z_OK ||
      made != out.size())
    return broken;
  return out;
}

}  // namespace trephine::sim
