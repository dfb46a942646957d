// SkullClamp: three pins hold the head. Commands plan pins and posture, a job fits the clamp, and findings
// judge the fit.
#pragma once

#include "modules/skull_clamp/fit.h"

namespace trephine::skull_clamp {

/// Command: places the next pin. The first is the single pin, the others are the pair.
struct PlacePin {
  glm::dvec3 at{0.0};  ///< mm, world: position on the head
  static const sim::Schema& schema();
};
struct MovePin {
  std::int64_t number = 1;  ///< starts at 1
  glm::dvec3 at{0.0};       ///< mm, world
  static const sim::Schema& schema();
};
struct ClearPins {
  static const sim::Schema& schema();
};
/// Command: sets the posture of the patient. The head stays where it is, so the floor moves.
struct SetPosture {
  glm::dvec3 up{0, -1, 0};  ///< direction away from the floor, in the frame of the head
  double turn = 0;          ///< degrees, see ClampPlan
  static const sim::Schema& schema();
};

/// Command: chooses the clamp.
struct SetClamp {
  ClampModel model = ClampModel::standard;
  static const sim::Schema& schema();
};

class SkullClamp final : public sim::Module {
 public:
  std::string_view name() const noexcept override { return "skull_clamp"; }
  std::uint32_t version() const noexcept override { return 2; }  // 2: models; contact with the head
  std::span<const sim::ValueType* const> commands() const override;
  std::span<const sim::JobType* const> jobs() const override;
  std::span<const sim::ValueType* const> events() const override;
  sim::Value settings() const override { return ClampPlan{}; }
  sim::Value result() const override { return ClampFitted{}; }
  Status allows(const sim::Command& command, const sim::OperationState& operation) const override;
  void apply(const sim::Command& command, sim::ModuleWork& work) const override;
  std::vector<sim::Measure> measures(const sim::OperationState& operation) const override;
  std::vector<sim::Finding> findings(const sim::JobInput& input) const override;
  sim::Overlays overlays(const sim::OperationState& operation) const override;
};

}  // namespace trephine::skull_clamp
