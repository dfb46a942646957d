// CrossSection: section plane of an operation, and measurement of areas in a plane.
#pragma once

#include "modules/cross_section/section.h"
#include "sim/api/module.h"

namespace trephine::cross_section {

/// Section plane that views show. It is both a command and the settings of this module; undo does not change
/// it.
struct SectionPlane {
  glm::dvec3 at{0.0};          ///< mm, world
  glm::dvec3 normal{0, 0, 1};  ///< toward the viewer
  bool is_clipping = false;    ///< views hide everything in front of the plane
  static const sim::Schema& schema();
};

/// Job that measures the areas in a plane. It changes no anatomy.
struct MeasureSection {
  glm::dvec3 at{0.0}, normal{0, 0, 1};  ///< world; centre of the measured square, mm; its normal, any length
  double pixel = 0.2;                   ///< mm, of the raster in which areas outside bone are counted
  double width = 200;                   ///< mm, of the measured square
  std::int64_t item = 0;                ///< index of the bone's shape in the anatomy
  static const sim::Schema& schema();
};

/// Areas in a plane, the result of this module. Emitted at the plane's centre.
struct SectionMeasured {
  double bone = 0;          ///< mm2
  double models = 0;        ///< mm2 of closed models and implants of metal
  double outside = 0;       ///< mm2 of their part outside the bone as it was before any cut
  std::string open_models;  ///< names of models that are not measured, because they are not closed
  static const sim::Schema& schema();
};

class CrossSection final : public sim::Module {
 public:
  std::string_view name() const noexcept override { return "cross_section"; }
  std::span<const sim::ValueType* const> commands() const override;
  std::span<const sim::JobType* const> jobs() const override;
  std::span<const sim::ValueType* const> events() const override;
  sim::Value settings() const override { return SectionPlane{}; }
  sim::Value result() const override { return SectionMeasured{}; }
  Status allows(const sim::Command& command, const sim::OperationState& operation) const override;
  void apply(const sim::Command& command, sim::ModuleWork& work) const override;
  std::vector<sim::Measure> measures(const sim::OperationState& operation) const override;
};

}  // namespace trephine::cross_section
