#include "sim/api/module.h"

#include <utility>

namespace trephine::sim {

namespace {
/// Largest number of events of a tick or a command. Further events of reactions are dropped, so that modules
/// cannot react to each other endlessly.
constexpr std::size_t k_max_events = 1000;
}  // namespace

void ModuleReaction::raise_event(Value value, const glm::dvec3& position_world) {
  if (events_->size() < k_max_events) events_->push_back({tick_, hand_, position_world, std::move(value)});
}

Status Module::allows(const Command&, const OperationState&) const { return std::nullopt; }
void Module::apply(const Command&, ModuleWork&) const {}
void Module::react(const Event&, const OperationState&, ModuleReaction&) const {}
void Module::react_to_command(const Command&, const OperationState&, ModuleReaction&) const {}
bool Module::is_moving(const OperationState&) const { return false; }
Overlays Module::overlays(const OperationState&) const { return {}; }
std::vector<Measure> Module::measures(const OperationState&) const { return {}; }
std::vector<Finding> Module::findings(const JobInput&) const { return {}; }

}  // namespace trephine::sim
