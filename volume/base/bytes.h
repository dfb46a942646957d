// Binary encoding of plain values: little endian, with checked reads.
#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>
#include <type_traits>

namespace trephine {

static_assert(std::endian::native == std::endian::little, "files are little endian");

template <class T>
void put(std::string& out, const T& value) {
  static_assert(std::is_trivially_copyable_v<T>);
  const std::size_t at = out.size();
  out.resize(at + sizeof value);
  std::memcpy(out.data() + at, &value, sizeof value);
}

/// Reads a value and removes its bytes from the front of `in`. Returns false and leaves `in` unchanged if it
/// has too few bytes.
template <class T>
bool get(std::string_view& in, T& value) {
  static_assert(std::is_trivially_copyable_v<T>);
  if (in.size() < sizeof value) return false;
  std::memcpy(&value, in.data(), sizeof value);
  in.remove_prefix(sizeof value);
  return true;
}

/// Appends a signed number in a variable length (zigzag, LEB128): 1 byte up to 63, 2 up to 8191, and so on.
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

/// Appends values with run-length encoding. A run of equal values is a 16-bit length and one value. A
/// sequence of values without equal neighbours is a length, whose high bit is set, and all values of the
/// sequence.
template <class T>
void put_runs(std::string& out, const T* values, std::size_t count) {
  constexpr std::size_t k_longest_run = 0x7fff;
  const auto is_equal = [values](std::size_t a, std::size_t b) {
    return std::memcmp(&values[a], &values[b], sizeof(T)) == 0;
  };
  for (std::size_t i = 0; i < count;) {
    const std::size_t last = std::min(count, i + k_longest_run);
    std::size_t end = i + 1;
    while (end < last && is_equal(end, i)) ++end;
    const bool is_run = end - i > 1;
    // Literals extend to the start of the next run.
    if (!is_run)
      while (end < last && !(end + 1 < count && is_equal(end, end + 1))) ++end;
    put(out, static_cast<std::uint16_t>((end - i) | (is_run ? 0u : 0x8000u)));
    out.append(reinterpret_cast<const char*>(values + i), (is_run ? 1 : end - i) * sizeof(T));
    i = end;
  }
}
/// Reads `count` values that put_runs() appended. Returns false if the bytes are invalid.
template <class T>
bool get_runs(std::string_view& in, T* values, std::size_t count) {
  for (std::size_t i = 0; i < count;) {
    std::uint16_t head = 0;
    if (!get(in, head)) return false;
    const std::size_t length = head & 0x7fffu;
    if (length == 0 || length > count - i) return false;
    if (head & 0x8000u) {
      const std::size_t size = length * sizeof(T);
      if (in.size() < size) return false;
      std::memcpy(values + i, in.data(), size);
      in.remove_prefix(size);
    } else {
      T value;
      if (!get(in, value)) return false;
      std::fill_n(values + i, length, value);
    }
    i += length;
  }
  return true;
}

/// Appends the length of the text, then its bytes.
inline void put_text(std::string& out, std::string_view text) {
  put_number(out, static_cast<std::int64_t>(text.size()));
  out += text;
}
inline bool get_text(std::string_view& in, std::string_view& text) {
  std::int64_t length = 0;
  if (!get_number(in, length) || length < 0 || static_cast<std::uint64_t>(length) > in.size()) return false;
  text = in.substr(0, static_cast<std::size_t>(length));
  in.remove_prefix(static_cast<std::size_t>(length));
  return true;
}

}  // namespace trephine
