// Numbers as text, identical on every machine; text for SVG.
#pragma once

#include <charconv>
#include <cstdint>
#include <string>
#include <string_view>

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

/// Returns the text with &, <, > and \" replaced by the entities of SVG.
inline std::string escape_svg(std::string_view text) {
  std::string out;
  for (const char c : text) {
    if (c == '&')
      out += "&amp;";
    else if (c == '<')
      out += "&lt;";
    else if (c == '>')
      out += "&gt;";
    else if (c == '"')
      out += "&quot;";
    else
      out += c;
  }
  return out;
}

}  // namespace trephine
