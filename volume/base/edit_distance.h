// edit_distance(): similarity of words, for errors about misspelt names.
#pragma once

#include <algorithm>
#include <numeric>
#include <string_view>
#include <vector>

namespace trephine {

/// Returns the smallest number of letters to change, add or omit that turns one word into the other
/// (Levenshtein 1966).
inline std::size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (const char letter : a) {
    std::size_t diagonal = row[0]++;
    for (std::size_t j = 0; j < b.size(); ++j) {
      const std::size_t changed = diagonal + (letter != b[j]);
      diagonal = row[j + 1];
      row[j + 1] = std::min({changed, row[j] + 1, row[j + 1] + 1});
    }
  }
  return row.back();
}

}  // namespace trephine
