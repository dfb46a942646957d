// Plain values as bytes of a file: little endian, and every read is checked.
#pragma once

#include <bit>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>
#include <type_traits>

namespace trephine::sim {

static_assert(std::endian::native == std::endian::little, "files are little endian");

template <class T>
void put(std::string& out, const T& value) {
  static_assert(std::is_trivially_copyable_v<T>);
  const std::size_t at = out.size();
  out.resize(at + sizeof value);
  std::memcpy(out.data() + at, &value, sizeof value);
}

/// Takes the value off the front; false, and nothing is taken, when the bytes are too few.
template <class T>
bool get(std::string_view& in, T& value) {
  static_assert(std::is_trivially_copyable_v<T>);
  if (in.size() < sizeof value) return false;
  std::memcpy(&value, in.data(), sizeof value);
  in.remove_prefix(sizeof value);
  return true;
}

/// Small numbers of either sign in few bytes: 1 up to 63, 2 up to 8191, and so on.
inline void put_number(std::string& out, std::int64_t value) {
  auto rest = static_cast<std::uint64_t>(value) << 1 ^ static_cast<std::uint64_t>(value >> 63);
  for (; rest >= 0x80; rest >>= 7) out += static_cast<char>(rest | 0x80);
  out += static_cast<char>(rest);
}
inline bool get_number(std::string_view& in, std::int64_t& value) {
  std::uint64_t rest = 0;
  for (unsigned shift = 0;; shift += 7) {
    std::uint8_t byte = 0;
    if (shift > 63 || !get(in, byte)) return false;
    rest |= std::uint64_t{byte & 0x7fu} << shift;
    if (byte < 0x80) break;
  }
  value = static_cast<std::int64_t>(rest >> 1) ^ -static_cast<std::int64_t>(rest & 1);
  return true;
}

}  // namespace trephine::sim
