#include "sim/api/catalogue.h"

#include <algorithm>
#include <array>

#include "sim/api/core_command.h"

namespace trephine::sim {

namespace {

/// Events of any engine, whatever its modules.
std::array<const ValueType*, 12> own_events() noexcept {
  return {&value_type<FaultEvent>(),    &value_type<JobDiscarded>(),      &value_type<ForbiddenEntered>(),
          &value_type<ForbiddenLeft>(), &value_type<StructureStripped>(), &value_type<StructureTouched>(),
          &value_type<StructureTorn>(), &value_type<PieceFreed>(),        &value_type<BodyAdded>(),
          &value_type<DebrisFreed>(),   &value_type<StepEntered>(),       &value_type<StepRefused>()};
}

/// Returns the types of a module's commands, events, instruments and jobs.
std::vector<const ValueType*> types_of(const Module& module) {
  std::vector<const ValueType*> types(module.commands().begin(), module.commands().end());
  types.insert(types.end(), module.events().begin(), module.events().end());
  for (const InstrumentType* instrument : module.instruments()) types.push_back(instrument->parameters);
  for (const JobType* job : module.jobs()) types.push_back(job->parameters);
  return types;
}

}  // namespace

bool contains(std::span<const ValueType* const> all, const ValueType& type) noexcept {
  return std::find(all.begin(), all.end(), &type) != all.end();
}

const InstrumentType* Catalogue::find_instrument(std::string_view name) const noexcept {
  for (const Module* module : modules_)
    for (const InstrumentType* instrument : module->instruments())
      if (instrument->name() == name) return instrument;
  return nullptr;
}

std::vector<const ValueType*> Catalogue::all() const {
  const auto events = own_events();
  std::vector<const ValueType*> types;
  for (const CoreCommand& command : core_commands()) types.push_back(command.type);
  types.insert(types.end(), events.begin(), events.end());
  for (const Module* module : modules_) {
    const std::vector<const ValueType*> own = types_of(*module);
    types.insert(types.end(), own.begin(), own.end());
  }
  return types;
}

const ValueType* Catalogue::find(std::string_view name) const noexcept {
  for (const ValueType* type : all())
    if (type->schema->name == name) return type;
  return nullptr;
}

bool Catalogue::is_event(const ValueType& type) const noexcept {
  return contains(own_events(), type) ||
         std::any_of(modules_.begin(), modules_.end(),
                     [&](const Module* module) { return contains(module->events(), type); });
}

bool Catalogue::is_command(const ValueType& type) const noexcept {
  const CoreCommand* core = find_core_command(type);
  return core ? core->is_for_users : !is_event(type);
}

Result<Command> Catalogue::command(std::string_view name, std::string_view words, int hand) const {
  const ValueType* type = find(name);
  if (type == nullptr || !is_command(*type)) {
    std::string known;
    for (const ValueType* one : all())
      if (is_command(*one)) known.append(known.empty() ? "" : ", ").append(one->schema->name);
    return Error{.what = "unknown command",
                 .found = std::string(name),
                 .expected = known,
                 .remedy = "choose one of these"};
  }
  Value request = Value::of(*type);
  if (Status error = request.set(words)) return *error;
  return Command(std::move(request), static_cast<std::uint8_t>(hand));
}

Status Catalogue::check() const {
  std::vector<std::string_view> names;
  for (const ValueType* type : all()) names.push_back(type->schema->name);
  std::sort(names.begin(), names.end());
  const auto twice = std::adjacent_find(names.begin(), names.end());
  if (twice == names.end()) return std::nullopt;
  std::string owners;
  for (const Module* module : modules_)
    for (const ValueType* type : types_of(*module))
      if (type->schema->name == *twice) owners.append(owners.empty() ? "" : " and ").append(module->name());
  return Error{.what = "two commands, events, instruments or jobs have the same name",
               .found = std::string(*twice) + ", in " + owners,
               .expected = "unique names of commands, events, instruments and jobs",
               .remedy = "rename it in one module, or load only one of them"};
}

}  // namespace trephine::sim
