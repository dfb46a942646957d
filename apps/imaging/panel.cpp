#include "apps/imaging/panel.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <utility>

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

void add_trajectory(Panel& panel, const glm::dvec2& entry, const glm::dvec2& target,
                    const std::string& name) {
  constexpr double k_turn = 6.283185307179586;
  constexpr int k_corners = 24;
  panel.lines.push_back({{entry, target}, k_plan_colour, false, "plan (ring: entry)", true});
  Panel::Line ring{{}, k_plan_colour, true, "plan (ring: entry)", true};
  const double radius = 0.008 * panel.mm_per_pixel * panel.columns;
  for (int i = 0; i < k_corners; ++i)
    ring.points.push_back(
        entry + radius * glm::dvec2(std::cos(i * k_turn / k_corners), std::sin(i * k_turn / k_corners)));
  panel.lines.push_back(std::move(ring));
  // If the entry is in the middle of all marked points, its name is on the side away from the target.
  panel.labels.push_back({entry, name, k_plan_colour, target.x > entry.x, radius});
}

void mirror(Panel& panel) {
  for (int row = 0; row < panel.rows; ++row) {
    const auto begin = panel.pixels.begin() + static_cast<std::ptrdiff_t>(row) * panel.columns;
    std::reverse(begin, begin + panel.columns);
  }
  for (Panel::Line& line : panel.lines)
    for (glm::dvec2& point : line.points) point.x = -point.x;
  for (Panel::Label& label : panel.labels)
    label.point.x = -label.point.x, label.is_to_left = !label.is_to_left;
  std::swap(panel.left, panel.right);
}

int bar_length(double longest) noexcept {
  int mm = 1;
  for (const int longer : {2, 5, 10, 20, 50, 100})
    if (longer <= longest) mm = longer;
  return mm;
}

}  // namespace trephine::imaging
