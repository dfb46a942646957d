#include "modules/ct_viewer/grey_window.h"

#include <algorithm>
#include <vector>

namespace trephine::ct_viewer {

GreyWindow window_of(std::span<const std::int16_t> values, std::int16_t excluded) {
  std::vector<std::int16_t> counted;
  for (const std::int16_t v : values)
    if (v != excluded) counted.push_back(v);
  if (counted.empty()) return {0, 1};
  const std::size_t rare = counted.size() / 200;
  const auto at = [&](std::size_t i) {
    std::nth_element(counted.begin(), counted.begin() + static_cast<std::ptrdiff_t>(i), counted.end());
    return static_cast<double>(counted[i]);
  };
  const double low = at(rare), high = at(counted.size() - 1 - rare);
  return {0.5 * (low + high), std::max(1.0, high - low)};
}

}  // namespace trephine::ct_viewer
