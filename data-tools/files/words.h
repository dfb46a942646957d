// Text helpers: numbers, plurals, lists and UTF-8 in messages.
#pragma once

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace trephine::data_tools {

/// Returns the value of a header line "key: value" or "key = value", with the key in upper or lower case and
/// any blanks or tabs between; nullopt for another line.
inline std::optional<std::string> header_value(const std::string& line, std::string_view key) {
  const auto lower = [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; };
  constexpr const char* k_blank = " \t";
  if (line.size() < key.size() ||
      !std::equal(key.begin(), key.end(), line.begin(), [&](char a, char b) { return lower(a) == lower(b); }))
    return std::nullopt;
  const std::size_t separator = line.find_first_not_of(k_blank, key.size());
  if (separator == std::string::npos || (line[separator] != ':' && line[separator] != '='))
    return std::nullopt;
  // NRRD writes "key:=value" for keys that the format does not define.
  const std::size_t value = line.find_first_not_of(" \t:=", separator);
  return value == std::string::npos ? "" : line.substr(value);
}

/// Returns a number with its noun: "1 slice", "3 slices".
inline std::string counted(std::size_t n, const std::string& noun) {
  std::string text = std::to_string(n);
  return text.append(" ").append(noun).append(n == 1 ? "" : "s");
}

/// Returns the number of bytes of the UTF-8 character at `at` (RFC 3629: no overlong forms, no surrogates);
/// 0 if it is invalid.
inline std::size_t utf8_length(std::string_view text, std::size_t at) {
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  if (byte(at) < 0x80) return 1;
  const std::size_t trailing = byte(at) >= 0xc2 && byte(at) <= 0xdf   ? 1
                               : byte(at) >= 0xe0 && byte(at) <= 0xef ? 2
                               : byte(at) >= 0xf0 && byte(at) <= 0xf4 ? 3
                                                                      : 0;
  if (trailing == 0 || at + trailing >= text.size()) return 0;
  std::uint32_t code = byte(at) & (0x3fu >> trailing);
  for (std::size_t k = 1; k <= trailing; ++k) {
    if ((byte(at + k) & 0xc0) != 0x80) return 0;
    code = code << 6 | (byte(at + k) & 0x3fu);
  }
  const bool is_overlong = (trailing == 2 && code < 0x800) || (trailing == 3 && code < 0x10000);
  const bool is_no_character = (code >= 0xd800 && code < 0xe000) || code > 0x10ffff;
  return is_overlong || is_no_character ? 0 : trailing + 1;
}

inline bool is_utf8(std::string_view text) {
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t length = utf8_length(text, at);
    if (length == 0) return false;
    at += length;
  }
  return true;
}

/// Returns valid UTF-8 unchanged, other text converted from Latin-1.
inline std::string utf8_text(const std::string& text) {
  if (is_utf8(text)) return text;
  std::string latin;
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (byte < 0x80) {
      latin += c;
    } else {
      latin += static_cast<char>(0xc0 | byte >> 6);
      latin += static_cast<char>(0x80 | (byte & 0x3f));
    }
  }
  return latin;
}

/// Returns the first `max_count` names and the number of the others: "a, b and 3 more".
inline std::string list_of(const std::vector<std::string>& names, std::size_t max_count = 5) {
  std::string text;
  for (std::size_t i = 0; i < std::min(names.size(), max_count); ++i)
    text.append(i == 0 ? "" : ", ").append(names[i]);
  if (names.size() > max_count)
    text.append(" and ").append(std::to_string(names.size() - max_count)).append(" more");
  return text;
}

}  // namespace trephine::data_tools
