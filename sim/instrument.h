// Instruments of a hand. An instrument sees every tick, with the button and without; it answers with edits
// and events, never with forces, since it runs ticks late.
#pragma once

#include <type_traits>

#include "haptics/servo/servo_core.h"
#include "sim/forbidden.h"
#include "sim/work.h"

namespace trephine::sim {

struct InstrumentInput {
  const haptics::ServoRecord& tick;
  double dt;  ///< s
  /// Nothing led here: the first tick of all, with these parameters, or after an undo; what the state says is
  /// of another stroke.
  bool is_fresh;
};

/// Needs of an instrument, for which a session is prepared.
struct ToolNeeds {
  double finest_cut = 0;    ///< mm, diameter of what it cuts with; 0: it cuts nothing
  double touch_radius = 0;  ///< mm, of the ball that the hand touches with; 0: a point, or what the hand has
  std::vector<glm::dvec3> balls = {};  ///< mm, seen from the hand: middles of several such balls; none: one
};

/// An instrument is a function of its module, parameters with a table, and a state with a table. Made by
/// instrument_type().
struct InstrumentType {
  const ValueType* parameters;  ///< its name is the instrument's; set midway by a command of this value
  const ValueType* state;
  void (*step)(const void* parameters, void* state, const InstrumentInput& input, Work& work);
  /// Beyond each field's range: whether these parameters fit what the hand touches. May be null.
  volume::Status (*check)(const void* parameters, const haptics::TouchScene& scene) = nullptr;
  /// Position of its body after that tick; asked near forbidden structures. May be null: it has no body.
  ToolBall (*body)(const void* parameters, const void* state, const InstrumentInput& input) = nullptr;
  /// Needs in a session over that anatomy. May be null: nothing.
  ToolNeeds (*needs)(const void* parameters, const volume::Volume& anatomy) = nullptr;
  /// The force that it makes in addition to surfaces while a hand has it, in words (haptics::parse_effect);
  /// empty: none. May be null: never any.
  std::string (*effect)(const void* parameters) = nullptr;

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

/// From `void step(const Parameters&, State&, const InstrumentInput&, Work&)`, and those that it has of
/// `Status check(const Parameters&, const TouchScene&)`,
/// `ToolBall body(const Parameters&, const State&, const InstrumentInput&)` and
/// `ToolNeeds needs(const Parameters&, const volume::Volume&)` and `std::string effect(const Parameters&)`;
/// nullptr in place of one that it has not.
template <auto k_step, auto k_check = nullptr, auto k_body = nullptr, auto k_needs = nullptr,
          auto k_effect = nullptr>
const InstrumentType& instrument_type() noexcept {
  using Parameters = typename detail::InstrumentParts<decltype(k_step)>::Parameters;
  using State = typename detail::InstrumentParts<decltype(k_step)>::State;
  static const InstrumentType type = [] {
    InstrumentType made{&value_type<Parameters>(), &value_type<State>(),
                        [](const void* p, void* s, const InstrumentInput& input, Work& work) {
                          k_step(*static_cast<const Parameters*>(p), *static_cast<State*>(s), input, work);
                        }};
    if constexpr (!std::is_null_pointer_v<decltype(k_check)>)
      made.check = [](const void* p, const haptics::TouchScene& scene) -> volume::Status {
        return k_check(*static_cast<const Parameters*>(p), scene);
      };
    if constexpr (!std::is_null_pointer_v<decltype(k_body)>)
      made.body = [](const void* p, const void* s, const InstrumentInput& input) -> ToolBall {
        return k_body(*static_cast<const Parameters*>(p), *static_cast<const State*>(s), input);
      };
    if constexpr (!std::is_null_pointer_v<decltype(k_needs)>)
      made.needs = [](const void* p, const volume::Volume& anatomy) -> ToolNeeds {
        return k_needs(*static_cast<const Parameters*>(p), anatomy);
      };
    if constexpr (!std::is_null_pointer_v<decltype(k_effect)>)
      made.effect = [](const void* p) -> std::string { return k_effect(*static_cast<const Parameters*>(p)); };
    return made;
  }();
  return type;
}

/// One in a hand. Without a type: the hand only touches.
struct Instrument {
  const InstrumentType* type = nullptr;
  Value parameters, state;

  Instrument() = default;
  Instrument(const InstrumentType& which, Value with)
      : type(&which), parameters(std::move(with)), state(Value::of(*which.state)) {}
  std::string_view name() const noexcept { return type ? type->name() : std::string_view(); }
};

}  // namespace trephine::sim
