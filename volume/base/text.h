// Numbers as text, identical on every machine.
#pragma once

#include <charconv>
#include <cstdint>
#include <string>

namespace trephine {

/// Shortest decimal text that reads back as exactly this value.
inline std::string text_of(double v) {
  char text[40];
  return std::string(text, std::to_chars(text, text + sizeof text, v).ptr);
}
/// Decimal text with at most six significant digits, for messages.
inline std::string rounded_text(double v) {
  char text[40];
  return std::string(text, std::to_chars(text, text + sizeof text, v, std::chars_format::general, 6).ptr);
}
/// Sixteen hexadecimal digits, for hashes.
inline std::string hexadecimal(std::uint64_t v) {
  std::string text(16, '0');
  for (std::size_t i = 16; i-- > 0; v >>= 4) text[i] = "0123456789abcdef"[v & 15u];
  return text;
}

}  // namespace trephine
