#include "sim/api/operation_state.h"

namespace trephine::sim {

std::uint64_t OperationState::hash() const {
  MixHash result;
  result.add(next_tick);
  result.add(undoable.version->content_hash());
  result.add(static_cast<std::uint64_t>(undoable.version->ledger().detached_units));
  for (const auto* modules : {&undoable.modules, &settings.modules})
    for (const auto& value : *modules)
      if (value) add_value(result, *value);
  for (const ModuleResult& one : settings.results)
    if (one.value) {
      add_value(result, *one.value);
      result.add(one.edits);
    }
  for (const Body& body : undoable.bodies) {
    result.add(std::uint64_t{body.id.value});
    result.add(static_cast<std::uint64_t>(body.mover));
    result.add(static_cast<std::uint64_t>(body.holder + 1));
    for (const haptics::Placement& at : {body.placement, body.grip}) {
      for (int a = 0; a < 3; ++a) result.add(at.position_world[a]);
      for (int a = 0; a < 4; ++a) result.add(at.rotation[a]);
    }
    result.add(body.piece->hash);
    if (!body.is_implant) continue;
    result.add(static_cast<std::uint64_t>(body.matter));
    result.add(std::uint64_t{body.is_fixed});
    result.add(body.motion.begin_tick);
    result.add(body.motion.seconds);
  }
  if (const ProcedurePosition& position = undoable.procedure; position.step >= 0) {
    result.add(static_cast<std::uint64_t>(position.step));
    result.add(position.entered_tick);
    result.add(position.first_event);
    for (const std::uint32_t count : position.visits) result.add(std::uint64_t{count});
  }
  for (const auto& [key, command] : settings.latest_commands) {
    add_bytes(result, key);
    add_value(result, command.request);
  }
  for (const Instrument& hand : settings.hands) {
    add_value(result, hand.parameters);
    add_value(result, hand.state);
  }
  result.add(chronicle.hash());
  for (const ForbiddenWatch& watch : watches) {
    std::string bytes;
    encode_fields(ForbiddenWatch::schema(), &watch, bytes);
    add_bytes(result, bytes);
  }
  return result.value();
}

}  // namespace trephine::sim
