// Catalogue: the modules of a program, with their commands, events, instruments and jobs.
#pragma once

#include <vector>

#include "sim/api/module.h"

namespace trephine::sim {

/// True if `type` is one of `all`.
bool contains(std::span<const ValueType* const> all, const ValueType& type) noexcept;

/// Modules of a program, passed to an engine and to the reader of a session.
class Catalogue {
 public:
  Catalogue() = default;
  Catalogue(std::vector<const Module*> modules) : modules_(std::move(modules)) {}
  const std::vector<const Module*>& modules() const noexcept { return modules_; }
  const InstrumentType* find_instrument(std::string_view name) const noexcept;
  /// Finds a command, an event, or the parameters of an instrument or a job by name; null if unknown.
  const ValueType* find(std::string_view name) const noexcept;
  std::vector<const ValueType*> all() const;
  /// True for types that an engine or a module emits; such types are never sent to an engine.
  bool is_event(const ValueType& type) const noexcept;
  /// True if a user or a script may send a command of this type; false for events, and for commands that only
  /// drivers issue.
  bool is_command(const ValueType& type) const noexcept;
  /// Builds a command from its name and its fields in words. The engine checks whether it is allowed.
  Result<Command> command(std::string_view name, std::string_view words, int hand = 0) const;
  /// Error if two types have the same name.
  Status check() const;

 private:
  std::vector<const Module*> modules_;
};

}  // namespace trephine::sim
