#include "apps/imaging/panel.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

namespace trephine::imaging {

std::string direction_letters(const glm::dvec3& direction) {
  std::array<std::pair<double, char>, 3> parts{{{std::abs(direction.x), direction.x > 0 ? 'L' : 'R'},
                                                {std::abs(direction.y), direction.y > 0 ? 'P' : 'A'},
                                                {std::abs(direction.z), direction.z > 0 ? 'S' : 'I'}}};
  std::stable_sort(parts.begin(), parts.end(),
                   [](const auto& a, const auto& b) { return a.first > b.first; });
  std::string letters;
  for (const auto& [share, letter] : parts)
    if (share > 0.4 * glm::length(direction) && letters.size() < 2) letters += letter;
  return letters;
}

void set_letters(Panel& panel, const glm::dvec3& right_world, const glm::dvec3& up_world) {
  panel.left = direction_letters(-right_world), panel.right = direction_letters(right_world);
  panel.above = direction_letters(up_world), panel.below = direction_letters(-up_world);
}

void mirror(Panel& panel) {
  for (int row = 0; row < panel.rows; ++row) {
    const auto begin = panel.pixels.begin() + static_cast<std::ptrdiff_t>(row) * panel.columns;
    std::reverse(begin, begin + panel.columns);
  }
  for (Panel::Line& line : panel.lines)
    for (glm::dvec2& point : line.places) point.x = -point.x;
  std::swap(panel.left, panel.right);
}

int bar_length(double longest) noexcept {
  int mm = 1;
  for (const int longer : {2, 5, 10, 20, 50, 100})
    if (longer <= longest) mm = longer;
  return mm;
}

}  // namespace trephine::imaging
