// Numbers and lists in sentences for people.
#pragma once

#include <algorithm>
#include <cstdio>
#include <string>
#include <vector>

namespace trephine::data_tools {

/// Six digits at most.
inline std::string short_number(double v) {
  char text[40];
  std::snprintf(text, sizeof text, "%.6g", v);
  return text;
}

/// "1 slice", "3 slices".
inline std::string counted(std::size_t n, const std::string& what) {
  std::string text = std::to_string(n);
  return text.append(" ").append(what).append(n == 1 ? "" : "s");
}

/// The first of them, and how many more there are.
/// As it is where it is UTF-8, else as Latin-1 has it.
inline std::string utf8_text(const std::string& text) {
  std::string latin;
  bool is_utf8 = true;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const auto c = static_cast<unsigned char>(text[i]);
    if (c < 0x80) {
      latin += text[i];
      continue;
    }
    latin += static_cast<char>(0xc0 | c >> 6);
    latin += static_cast<char>(0x80 | (c & 0x3f));
  }
  for (std::size_t i = 0; i < text.size() && is_utf8;) {
    const auto c = static_cast<unsigned char>(text[i++]);
    int more = c < 0x80                ? 0
               : c >= 0xc2 && c < 0xe0 ? 1
               : c >= 0xe0 && c < 0xf0 ? 2
               : c >= 0xf0 && c < 0xf5 ? 3
                                       : -1;
    for (is_utf8 = more >= 0; more > 0 && is_utf8; --more)
      is_utf8 = i < text.size() && (static_cast<unsigned char>(text[i++]) & 0xc0) == 0x80;
  }
  return is_utf8 ? text : latin;
}

inline std::string list_of(const std::vector<std::string>& names, std::size_t most = 5) {
  std::string text;
  for (std::size_t i = 0; i < std::min(names.size(), most); ++i)
    text.append(i == 0 ? "" : ", ").append(names[i]);
  if (names.size() > most) text.append(" and ").append(std::to_string(names.size() - most)).append(" more");
  return text;
}

}  // namespace trephine::data_tools
