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
inline std::string list_of(const std::vector<std::string>& names, std::size_t most = 5) {
  std::string text;
  for (std::size_t i = 0; i < std::min(names.size(), most); ++i)
    text.append(i == 0 ? "" : ", ").append(names[i]);
  if (names.size() > most) text.append(" and ").append(std::to_string(names.size() - most)).append(" more");
  return text;
}

}  // namespace trephine::data_tools
