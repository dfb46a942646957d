// Formatting of texts with numbers, and of text in SVG.
#pragma once

#include <algorithm>
#include <cctype>
#include <cstdarg>
#include <cstdint>
#include <cstdio>
#include <string>
#include <string_view>

#include "volume/base/error.h"

namespace trephine::workbench {

/// Formats like printf into a string of at most 999 characters.
inline std::string format_text(const char* format, ...) __attribute__((format(printf, 1, 2)));
inline std::string format_text(const char* format, ...) {
  char text[1000];
  va_list arguments;
  va_start(arguments, format);
  std::vsnprintf(text, sizeof text, format, arguments);
  va_end(arguments);
  return text;
}

/// Returns the name of a label as words: "nerve_root" becomes "nerve root".
inline std::string words_of(std::string name) {
  std::replace(name.begin(), name.end(), '_', ' ');
  return name;
}

/// Returns an error as sentences for people, without its location: "the scan has no labels. Set a position in
/// its canal."
inline std::string sentences_of(const Error& error) {
  std::string text = error.what;
  if (!error.found.empty()) text += ": " + error.found;
  if (!error.expected.empty()) text += " (expected: " + error.expected + ")";
  text += '.';
  if (error.remedy.empty()) return text;
  std::string remedy = error.remedy;
  remedy[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(remedy[0])));
  return text + ' ' + remedy + '.';
}

/// Formats a content hash as 16 hexadecimal digits, for reports.
inline std::string hash_text(std::uint64_t hash) {
  return format_text("%016llx", static_cast<unsigned long long>(hash));
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

}  // namespace trephine::workbench
