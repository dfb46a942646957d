#include "sim/work.h"

namespace trephine::sim {

volume::RemovalReport Work::remove(const volume::Sweep& sweep) {
  const volume::RemovalReport one = editor_->remove(sweep);
  add(removed_, one);
  return one;
}

volume::RemovalReport Work::remove(const volume::ToolSweep& sweep) {
  const volume::RemovalReport one = editor_->remove(sweep);
  add(removed_, one);
  return one;
}

void Work::raise_event(Value what, const glm::dvec3& place_world) {
  events_->push_back({tick_, hand_, place_world, std::move(what)});
}

}  // namespace trephine::sim
