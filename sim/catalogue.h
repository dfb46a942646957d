// Abilities of a program in addition to touch: its modules, and their commands and events.
#pragma once

#include <vector>

#include "sim/module.h"

namespace trephine::sim {

/// Is it one of these?
bool holds(std::span<const ValueType* const> all, const ValueType& type) noexcept;

/// Abilities of a program: the maker of an engine, or the reader of a session, passes them.
class Catalogue {
 public:
  Catalogue() = default;
  Catalogue(std::vector<const Module*> modules) : modules_(std::move(modules)) {}
  const std::vector<const Module*>& modules() const noexcept { return modules_; }
  const InstrumentType* find_instrument(std::string_view name) const noexcept;
  /// Schemas of all commands, events, instruments and jobs.
  const ValueType* find(std::string_view name) const noexcept;
  std::vector<const ValueType*> all() const;
  /// Emitted by an engine or a module, never sent to one.
  bool is_event(const ValueType& type) const noexcept;
  /// May a person or a script send it? Not commands of derived data.
  bool is_command(const ValueType& type) const noexcept;
  /// A command by name, with its fields in words. Whether their values may be is the engine's to say.
  volume::Result<Command> command(std::string_view name, std::string_view words, int hand = 0) const;
  /// Error when two things have one name.
  volume::Status check() const;

 private:
  std::vector<const Module*> modules_;
};

}  // namespace trephine::sim
