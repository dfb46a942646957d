// Section plane of an operation, and its measurement.
#pragma once

#include "modules/cross_section/section.h"
#include "sim/module.h"

namespace trephine::cross_section {

/// A command, and kept: the plane that views show. Undo leaves it alone.
struct SectionPlane {
  glm::dvec3 at{0.0};          ///< mm, world
  glm::dvec3 normal{0, 0, 1};  ///< toward who looks at it
  bool is_clipping = false;    ///< views show nothing before it
  static const sim::Schema& schema();
};

/// A job: what lies in that plane. It changes nothing but what is known.
struct MeasureSection {
  glm::dvec3 at{0.0}, normal{0, 0, 1};
  double pixel = 0.2;     ///< mm, of what is counted
  double width = 200;     ///< mm, of the square that is looked at
  std::int64_t item = 0;  ///< the shape that is bone
  static const sim::Schema& schema();
};

/// Emitted at the plane's middle, and kept.
struct SectionMeasured {
  double bone = 0;          ///< mm2
  double models = 0;        ///< mm2 of closed models that are not of bone
  double outside = 0;       ///< mm2 of these outside bone
  std::string open_models;  ///< names of models that are not closed, and not counted
  static const sim::Schema& schema();
};

/// Settings of the module.
struct SectionState : SectionPlane {
  double bone = 0, models = 0, outside = 0;  ///< mm2, of what was measured last
  static const sim::Schema& schema();
};

class CrossSection final : public sim::Module {
 public:
  std::string_view name() const noexcept override { return "cross_section"; }
  std::span<const sim::ValueType* const> commands() const override;
  std::span<const sim::JobType* const> jobs() const override;
  std::span<const sim::ValueType* const> events() const override;
  sim::Value settings() const override { return SectionState{}; }
  volume::Status allows(const sim::Command& command, const sim::OperationState& now) const override;
  void apply(const sim::Command& command, sim::ModuleWork& work) const override;
  std::vector<sim::Measure> measures(const sim::OperationState& now) const override;
};

}  // namespace trephine::cross_section
