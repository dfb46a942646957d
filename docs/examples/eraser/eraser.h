// An eraser: takes away what its ball sweeps, touched or not, up to a limit. The example of
// docs/how-to/add-a-module.md.
#pragma once

#include "sim/module.h"

namespace trephine::eraser {

/// The instrument's parameters.
struct Eraser {
  double diameter = 3;  ///< mm
  static const sim::Schema& schema();
};

/// A command: from here on the eraser is refused once so much was erased.
struct LimitEraser {
  double most = 100;  ///< mm3
  static const sim::Schema& schema();
};

/// An event: a stroke of the eraser ended.
struct Erased {
  double amount = 0;  ///< mm3, by this stroke
  static const sim::Schema& schema();
};

/// State: of the world, so undo takes it back ...
struct EraserTotal {
  double amount = 0;   ///< mm3, by all strokes
  glm::dvec3 at{0.0};  ///< mm, world: where the newest one ended
  static const sim::Schema& schema();
};
/// ... and of the settings, which it leaves.
struct EraserLimit {
  double most = 1e6;  ///< mm3
  static const sim::Schema& schema();
};

/// The module.
class EraserModule final : public sim::Module {
 public:
  std::string_view name() const noexcept override { return "eraser"; }
  std::span<const sim::InstrumentType* const> instruments() const override;
  std::span<const sim::ValueType* const> commands() const override;
  std::span<const sim::ValueType* const> events() const override;
  sim::Value world() const override { return EraserTotal(); }
  sim::Value settings() const override { return EraserLimit(); }
  volume::Status allows(const sim::Command& command, const sim::OperationState& now) const override;
  void apply(const sim::Command& command, sim::ModuleWork& work) const override;
  void react(const sim::Event& event, sim::ModuleState& state) const override;
  std::vector<sim::Measure> measures(const sim::OperationState& now) const override;
  sim::Overlays overlays(const sim::OperationState& now) const override;
};

}  // namespace trephine::eraser
