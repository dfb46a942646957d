#include "modules/ct_viewer/grey_window.h"

#include <algorithm>
#include <vector>

namespace trephine::ct_viewer {

GreyWindow window_of(std::span<const std::int16_t> values, std::int16_t none) {
  std::vector<std::int16_t> known;
  for (const std::int16_t v : values)
    if (v != none) known.push_back(v);
  if (known.empty()) return {0, 1};
  const std::size_t rare = known.size() / 200;
  const auto at = [&](std::size_t i) {
    std::nth_element(known.begin(), known.begin() + static_cast<std::ptrdiff_t>(i), known.end());
    return static_cast<double>(known[i]);
  };
  const double low = at(rare), high = at(known.size() - 1 - rare);
  return {0.5 * (low + high), std::max(1.0, high - low)};
}

}  // namespace trephine::ct_viewer
