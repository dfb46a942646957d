// Numbers as text, the same on every machine.
#pragma once

#include <charconv>
#include <cstdint>
#include <string>

namespace trephine::volume {

/// As short as it can be read back exactly.
inline std::string text_of(double v) {
  char text[40];
  return std::string(text, std::to_chars(text, text + sizeof text, v).ptr);
}
/// Sixteen digits, for hashes.
inline std::string hexadecimal(std::uint64_t v) {
  std::string text(16, '0');
  for (std::size_t i = 16; i-- > 0; v >>= 4) text[i] = "0123456789abcdef"[v & 15u];
  return text;
}

}  // namespace trephine::volume
