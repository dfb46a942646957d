#include "sim/api/work.h"

namespace trephine::sim {

volume::RemovalReport Work::remove(const volume::Sweep& sweep) {
  const volume::RemovalReport report = editor_->remove(sweep);
  add(removed_, report);
  return report;
}

volume::RemovalReport Work::remove(const volume::ToolSweep& sweep) {
  const volume::RemovalReport report = editor_->remove(sweep);
  add(removed_, report);
  return report;
}

void Work::raise_event(Value value, const glm::dvec3& position_world) {
  events_->push_back({tick_, hand_, position_world, std::move(value)});
}

}  // namespace trephine::sim
