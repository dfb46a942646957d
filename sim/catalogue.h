// What a program can do beside touching: its modules, and what can be told to them and by them.
#pragma once

#include <vector>

#include "sim/module.h"

namespace trephine::sim {

/// Is it one of these?
bool holds(std::span<const ValueType* const> all, const ValueType& type) noexcept;

/// What a program can do: who makes an engine, or reads a session, says so.
class Catalogue {
 public:
  Catalogue() = default;
  Catalogue(std::vector<const Module*> modules) : modules_(std::move(modules)) {}
  const std::vector<const Module*>& modules() const noexcept { return modules_; }
  const InstrumentType* find_instrument(std::string_view name) const noexcept;
  /// Of all commands, events, instruments and jobs.
  const ValueType* find(std::string_view name) const noexcept;
  std::vector<const ValueType*> all() const;
  /// Told by an engine or a module, never to one.
  bool is_event(const ValueType& type) const noexcept;
  /// May a person or a script tell it? Not what keeps an engine's books.
  bool is_command(const ValueType& type) const noexcept;
  /// A command by name, with its fields in words. Whether their values may be is the engine's to say.
  volume::Result<Command> command(std::string_view name, std::string_view words, int hand = 0) const;
  /// Error when two things have one name.
  volume::Status check() const;

 private:
  std::vector<const Module*> modules_;
};

}  // namespace trephine::sim
