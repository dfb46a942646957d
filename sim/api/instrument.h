// Instrument: a tool in a hand. Its step function runs at every tick, with or without the button, and
// produces edits and events. It runs some ticks after the servo and so computes no force itself: it chooses
// the laws (HandForces) by which the servo computes forces.
#pragma once

#include <array>
#include <optional>
#include <type_traits>

#include "haptics/force/effects.h"
#include "haptics/servo/servo_record.h"
#include "sim/api/forbidden.h"
#include "sim/api/work.h"

namespace trephine::sim {

struct InstrumentInput {
  const haptics::ServoRecord& tick;
  double dt;  ///< s
  /// True in the hand's first tick, and in its first one after a stroke of any hand, an undoable change, an
  /// undo, or new parameters: the instrument's state then belongs to another stroke.
  bool is_fresh;
  double contact_radius = 0;  ///< mm, of the largest ball with which the hand touches; 0: a point, or the
                              ///< points of a shell
};

/// Needs of an instrument, for which a session is prepared.
struct ToolNeeds {
  double finest_cut = 0;               ///< mm, diameter of its cutting part; 0: it does not cut
  haptics::SharedTool tool = nullptr;  ///< with which the hand touches; null: the hand's initial tool
};

/// Forces that an instrument adds to those of surfaces, and items that it passes through. They depend only on
/// the parameters and the state of the instrument, so that a replay and an undo need no other data.
struct HandForces {
  static constexpr std::size_t k_max = 2;
  std::array<std::optional<haptics::Effect>, k_max> effects;
  haptics::ShapeSet passable_items;  ///< items of the scene that do not block the hand
  friend bool operator==(const HandForces&, const HandForces&) = default;
};

/// Type of an instrument: its step function, the types of its parameters and state, and optional functions.
/// Built by instrument_type().
struct InstrumentType {
  const ValueType* parameters;  ///< named as the instrument; a command of this type sets them
  const ValueType* state;
  void (*step)(const void* parameters, void* state, const InstrumentInput& input, Work& work);
  /// Checks the parameters against the hand's scene, in addition to each field's range. May be null.
  Status (*check)(const void* parameters, const haptics::TouchScene& scene) = nullptr;
  /// Returns the body of the tool after a tick; called if there are forbidden structures. Null: the tool has
  /// no body.
  ToolBall (*body)(const void* parameters, const void* state, const InstrumentInput& input) = nullptr;
  /// Returns the needs of the instrument in a session on `anatomy`. Null: no needs.
  ToolNeeds (*needs)(const void* parameters, const volume::Volume& anatomy) = nullptr;
  /// Returns the forces of the instrument after a tick; the servo applies them some ticks later. Null: no
  /// forces.
  HandForces (*forces)(const void* parameters, const void* state) = nullptr;
  /// Returns true while the instrument works without the button; its cuts then belong to one stroke. Null:
  /// the instrument works only while the button is pressed.
  bool (*is_working)(const void* parameters, const void* state) = nullptr;

  std::string_view name() const noexcept { return parameters->schema->name; }
};

namespace detail {
template <class Step>
struct InstrumentParts;
template <class P, class S>
struct InstrumentParts<void (*)(const P&, S&, const InstrumentInput&, Work&)> {
  using Parameters = P;
  using State = S;
};
}  // namespace detail

/// Builds a type from `void step(const Parameters&, State&, const InstrumentInput&, Work&)` and optionally
/// `Status check(const Parameters&, const TouchScene&)`,
/// `ToolBall body(const Parameters&, const State&, const InstrumentInput&)`,
/// `ToolNeeds needs(const Parameters&, const volume::Volume&)`,
/// `HandForces forces(const Parameters&, const State&)` and `bool is_working(const Parameters&, const
/// State&)`; nullptr for a function that the instrument lacks.
template <auto k_step, auto k_check = nullptr, auto k_body = nullptr, auto k_needs = nullptr,
          auto k_forces = nullptr, auto k_is_working = nullptr>
const InstrumentType& instrument_type() noexcept {
  using Parameters = typename detail::InstrumentParts<decltype(k_step)>::Parameters;
  using State = typename detail::InstrumentParts<decltype(k_step)>::State;
  static const InstrumentType type = [] {
    InstrumentType result{&value_type<Parameters>(), &value_type<State>(),
                          [](const void* p, void* s, const InstrumentInput& input, Work& work) {
                            k_step(*static_cast<const Parameters*>(p), *static_cast<State*>(s), input, work);
                          }};
    if constexpr (!std::is_null_pointer_v<decltype(k_check)>)
      result.check = [](const void* p, const haptics::TouchScene& scene) -> Status {
        return k_check(*static_cast<const Parameters*>(p), scene);
      };
    if constexpr (!std::is_null_pointer_v<decltype(k_body)>)
      result.body = [](const void* p, const void* s, const InstrumentInput& input) -> ToolBall {
        return k_body(*static_cast<const Parameters*>(p), *static_cast<const State*>(s), input);
      };
    if constexpr (!std::is_null_pointer_v<decltype(k_needs)>)
      result.needs = [](const void* p, const volume::Volume& anatomy) -> ToolNeeds {
        return k_needs(*static_cast<const Parameters*>(p), anatomy);
      };
    if constexpr (!std::is_null_pointer_v<decltype(k_forces)>)
      result.forces = [](const void* p, const void* s) -> HandForces {
        return k_forces(*static_cast<const Parameters*>(p), *static_cast<const State*>(s));
      };
    if constexpr (!std::is_null_pointer_v<decltype(k_is_working)>)
      result.is_working = [](const void* p, const void* s) -> bool {
        return k_is_working(*static_cast<const Parameters*>(p), *static_cast<const State*>(s));
      };
    return result;
  }();
  return type;
}

/// The instrument in a hand. Without a type the hand only touches.
struct Instrument {
  const InstrumentType* type = nullptr;
  Value parameters, state;

  Instrument() = default;
  Instrument(const InstrumentType& instrument, Value initial_parameters)
      : type(&instrument), parameters(std::move(initial_parameters)), state(Value::of(*instrument.state)) {}
  std::string_view name() const noexcept { return type ? type->name() : std::string_view(); }
};

}  // namespace trephine::sim
