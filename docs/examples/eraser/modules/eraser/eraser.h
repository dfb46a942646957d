// EraserModule: instrument that removes everything that its ball sweeps, with or without contact. After the
// total amount has reached a limit, the eraser is refused. Example of docs/how-to/add-a-module.md.
#pragma once

#include "sim/api/module.h"

namespace trephine::eraser {

/// Parameters of the instrument.
struct Eraser {
  double diameter = 3;  ///< mm
  static const sim::Schema& schema();
};

/// Command: sets the total amount from which on the eraser is refused.
struct LimitEraser {
  double max_amount = 100;  ///< mm3
  static const sim::Schema& schema();
};

/// Event: a stroke of the eraser ended.
struct Erased {
  double amount = 0;  ///< mm3, erased by this stroke
  static const sim::Schema& schema();
};

/// Undoable state.
struct EraserTotal {
  double amount = 0;   ///< mm3, erased by all strokes
  glm::dvec3 at{0.0};  ///< mm, world: end of the newest stroke
  static const sim::Schema& schema();
};
/// Persistent setting, which undo does not change.
struct EraserLimit {
  double max_amount = 1e6;  ///< mm3
  static const sim::Schema& schema();
};

class EraserModule final : public sim::Module {
 public:
  std::string_view name() const noexcept override { return "eraser"; }
  std::span<const sim::InstrumentType* const> instruments() const override;
  std::span<const sim::ValueType* const> commands() const override;
  std::span<const sim::ValueType* const> events() const override;
  sim::Value undoable() const override { return EraserTotal(); }
  sim::Value settings() const override { return EraserLimit(); }
  Status allows(const sim::Command& command, const sim::OperationState& now) const override;
  void apply(const sim::Command& command, sim::ModuleWork& work) const override;
  void react(const sim::Event& event, const sim::OperationState& now,
             sim::ModuleReaction& reaction) const override;
  std::vector<sim::Measure> measures(const sim::OperationState& now) const override;
  sim::Overlays overlays(const sim::OperationState& now) const override;
};

}  // namespace trephine::eraser
