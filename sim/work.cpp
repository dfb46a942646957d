#include "sim/work.h"

#include <glm/common.hpp>

namespace trephine::sim {

volume::VoxelBox united(const volume::VoxelBox& a, const volume::VoxelBox& b) noexcept {
  if (a.low.x > a.high.x) return b;
  if (b.low.x > b.high.x) return a;
  return {glm::min(a.low, b.low), glm::max(a.high, b.high)};
}

void add(volume::RemovalReport& sum, const volume::RemovalReport& one) noexcept {
  sum.removed_units += one.removed_units;
  sum.bricks_changed += one.bricks_changed;
  sum.box = united(sum.box, one.box);
}

volume::RemovalReport Work::remove(const volume::Sweep& sweep) {
  const volume::RemovalReport one = editor_->remove(sweep);
  add(removed_, one);
  return one;
}

void Work::raise_event(Value what, const glm::dvec3& place_world) {
  events_->push_back({tick_, hand_, place_world, std::move(what)});
}

}  // namespace trephine::sim
