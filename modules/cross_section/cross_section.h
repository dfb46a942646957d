// CrossSection: section plane of an operation, and measurement of areas in it.
#pragma once

#include "modules/cross_section/section.h"
#include "sim/api/module.h"

namespace trephine::cross_section {

/// Command, and part of the settings: the plane that views show. Undo does not change it.
struct SectionPlane {
  glm::dvec3 at{0.0};          ///< mm, world
  glm::dvec3 normal{0, 0, 1};  ///< toward the viewer
  bool is_clipping = false;    ///< views hide everything in front of it
  static const sim::Schema& schema();
};

/// Job that measures the areas in a plane. It changes no anatomy.
struct MeasureSection {
  glm::dvec3 at{0.0}, normal{0, 0, 1};  ///< mm, world
  double pixel = 0.2;                   ///< mm, of the raster in which areas outside bone are counted
  double width = 200;                   ///< mm, of the measured square
  std::int64_t item = 0;                ///< index of the bone's shape in the anatomy
  static const sim::Schema& schema();
};

/// Emitted at the plane's centre. The areas are kept in the settings.
struct SectionMeasured {
  double bone = 0;          ///< mm2
  double models = 0;        ///< mm2 of closed models, without detached bone
  double outside = 0;       ///< mm2 of these outside bone
  std::string open_models;  ///< names of models that are not closed, which are not counted
  static const sim::Schema& schema();
};

/// Settings of the module: the plane, and the last measurement.
struct SectionState : SectionPlane {
  double bone = 0, models = 0, outside = 0;  ///< mm2
  static const sim::Schema& schema();
};

class CrossSection final : public sim::Module {
 public:
  std::string_view name() const noexcept override { return "cross_section"; }
  std::span<const sim::ValueType* const> commands() const override;
  std::span<const sim::JobType* const> jobs() const override;
  std::span<const sim::ValueType* const> events() const override;
  sim::Value settings() const override { return SectionState{}; }
  Status allows(const sim::Command& command, const sim::OperationState& operation) const override;
  void apply(const sim::Command& command, sim::ModuleWork& work) const override;
  std::vector<sim::Measure> measures(const sim::OperationState& operation) const override;
};

}  // namespace trephine::cross_section
