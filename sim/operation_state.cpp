#include "sim/operation_state.h"

namespace trephine::sim {

std::uint64_t OperationState::hash() const {
  volume::MixHash all;
  all.add(next_tick);
  all.add(world.version->content_hash());
  all.add(static_cast<std::uint64_t>(world.version->ledger().freed_units));
  for (const auto* modules : {&world.modules, &settings.modules})
    for (const auto& value : *modules)
      if (value) add_value(all, *value);
  for (const Body& body : world.bodies) {
    all.add(std::uint64_t{body.id.value});
    all.add(static_cast<std::uint64_t>(body.mover));
    all.add(static_cast<std::uint64_t>(body.holder + 1));
    for (const haptics::Placement& at : {body.place, body.grip}) {
      for (int a = 0; a < 3; ++a) all.add(at.position_world[a]);
      for (int a = 0; a < 4; ++a) all.add(at.rotation[a]);
    }
    all.add(body.piece->hash);
  }
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
