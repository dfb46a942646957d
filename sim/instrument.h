// What a hand works with. An instrument sees every tick, with the button and without; it answers with edits
// and events, never with forces, since it runs ticks late.
#pragma once

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

/// An instrument is a function of its module, parameters with a table, and a state with a table. Made by
/// instrument_type().
struct InstrumentType {
  const ValueType* parameters;  ///< its name is the instrument's; set midway by a command of this value
  const ValueType* state;
  void (*step)(const void* parameters, void* state, const InstrumentInput& input, Work& work);
  /// Beyond each field's range: whether these parameters fit what the hand touches. May be null.
  volume::Status (*check)(const void* parameters, const haptics::TouchScene& scene);
  /// Where its body is after that tick; asked where something must not be cut. May be null: it has none.
  ToolBall (*body)(const void* parameters, const void* state, const InstrumentInput& input);

  std::string_view name() const noexcept { return parameters->schema->name; }
};

/// From `void step(const Parameters&, State&, const InstrumentInput&, Work&)`,
/// `Status check(const Parameters&, const TouchScene&)` and
/// `ToolBall body(const Parameters&, const State&, const InstrumentInput&)`.
template <auto k_step, auto k_check, auto k_body>
struct InstrumentOf;
template <class Parameters, class State,
          void (*k_step)(const Parameters&, State&, const InstrumentInput&, Work&),
          volume::Status (*k_check)(const Parameters&, const haptics::TouchScene&),
          ToolBall (*k_body)(const Parameters&, const State&, const InstrumentInput&)>
struct InstrumentOf<k_step, k_check, k_body> {
  static InstrumentType make() noexcept {
    return {&value_type<Parameters>(), &value_type<State>(),
            [](const void* p, void* s, const InstrumentInput& input, Work& work) {
              k_step(*static_cast<const Parameters*>(p), *static_cast<State*>(s), input, work);
            },
            [](const void* p, const haptics::TouchScene& scene) -> volume::Status {
              return k_check(*static_cast<const Parameters*>(p), scene);
            },
            [](const void* p, const void* s, const InstrumentInput& input) -> ToolBall {
              return k_body(*static_cast<const Parameters*>(p), *static_cast<const State*>(s), input);
            }};
  }
};
template <auto k_step, auto k_check, auto k_body>
const InstrumentType& instrument_type() noexcept {
  static const InstrumentType type = InstrumentOf<k_step, k_check, k_body>::make();
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
