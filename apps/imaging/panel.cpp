#include "apps/imaging/panel.h"

#include <glm/common.hpp>

namespace trephine::imaging {

char direction_letter(const glm::dvec3& direction_world) noexcept {
  const glm::dvec3 size = glm::abs(direction_world);
  if (size.x >= size.y && size.x >= size.z) return direction_world.x > 0 ? 'L' : 'R';
  if (size.y >= size.z) return direction_world.y > 0 ? 'P' : 'A';
  return direction_world.z > 0 ? 'S' : 'I';
}

void set_letters(Panel& panel, const glm::dvec3& right_world, const glm::dvec3& up_world) {
  panel.left = direction_letter(-right_world), panel.right = direction_letter(right_world);
  panel.above = direction_letter(up_world), panel.below = direction_letter(-up_world);
}

}  // namespace trephine::imaging
