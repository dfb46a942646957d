#include "sim/operation_state.h"

namespace trephine::sim {

std::uint64_t OperationState::hash() const {
  volume::MixHash all;
  all.add(next_tick);
  all.add(world.version->content_hash());
  for (const auto* modules : {&world.modules, &settings.modules})
    for (const auto& value : *modules)
      if (value) add_value(all, *value);
  for (const auto& [key, command] : settings.told) {
    add_bytes(all, key);
    add_value(all, command.what);
  }
  for (const Instrument& hand : settings.hands) {
    add_value(all, hand.parameters);
    add_value(all, hand.state);
  }
  all.add(chronicle.hash());
  for (const ForbiddenWatch& watch : watches) {
    std::string bytes;
    encode_fields(ForbiddenWatch::schema(), &watch, bytes);
    add_bytes(all, bytes);
  }
  return all.value();
}

}  // namespace trephine::sim
