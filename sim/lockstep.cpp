#include "sim/lockstep.h"

#include <glm/geometric.hpp>

namespace trephine::sim {

void remember_place(std::vector<glm::dvec3>& places, const glm::dvec3& place) {
  if (!places.empty() && glm::length(places.back() - place) < 0.5) return;
  if (places.size() >= 4096) places.erase(places.begin(), places.begin() + 2048);
  places.push_back(place);
}

Lockstep::Lockstep(const haptics::TouchScene& scene, const haptics::ProxyMethod& method, Tool* tool,
                   const haptics::ForceOptions& force, double rate_hz)
    : edits_(scene, tool, 1 / rate_hz), servo_(scene, method, force, 1 / rate_hz) {}

haptics::ServoRecord Lockstep::step(const haptics::Pose& pose, double t) {
  const haptics::ServoRecord record = servo_.step(*edits_.current(), pose, t, 0);
  if (servo_.proxy_state().has_proxy) remember_place(places_, servo_.proxy_state().proxy_volume);
  last_edit_ = edits_.consume(record);
  return record;
}

EditOutcome Lockstep::after_travel(EditOutcome outcome) {
  if (!outcome.is_changed) return outcome;
  if (const glm::dvec3* free = edits_.last_free(places_))
    servo_.restart_at(*free);
  else
    servo_.reset();
  return outcome;
}

EditOutcome Lockstep::undo() { return after_travel(edits_.undo()); }
EditOutcome Lockstep::redo() { return after_travel(edits_.redo()); }

}  // namespace trephine::sim
