#include "sim/api/module.h"

namespace trephine::sim {

Status Module::allows(const Command&, const OperationState&) const { return std::nullopt; }
void Module::apply(const Command&, ModuleWork&) const {}
void Module::react(const Event&, ModuleState&) const {}
bool Module::is_moving(const OperationState&) const { return false; }
Overlays Module::overlays(const OperationState&) const { return {}; }
std::vector<Measure> Module::measures(const OperationState&) const { return {}; }

}  // namespace trephine::sim
