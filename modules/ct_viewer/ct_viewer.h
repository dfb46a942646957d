// CtViewer: position and grey window of the slice views, kept with an operation so that a replay shows the
// slices, too.
#pragma once

#include "modules/ct_viewer/grey_window.h"
#include "sim/api/module.h"

namespace trephine::ct_viewer {

/// Command: moves the slices to a position.
struct LookAt {
  glm::dvec3 at{0.0};  ///< mm, world
  static const sim::Schema& schema();
};

/// Command: sets the grey window.
struct SetGreyWindow : GreyWindow {
  static const sim::Schema& schema();
};

/// Settings of the viewer. Undo does not change them.
struct CtViewerState : GreyWindow {
  glm::dvec3 at{0.0};            ///< mm, world
  bool has_position = false;     ///< a position was set
  bool has_grey_window = false;  ///< a grey window was set
  static const sim::Schema& schema();
};

class CtViewer final : public sim::Module {
 public:
  std::string_view name() const noexcept override { return "ct_viewer"; }
  std::span<const sim::ValueType* const> commands() const override;
  sim::Value settings() const override { return CtViewerState{}; }
  Status allows(const sim::Command& command, const sim::OperationState& operation) const override;
  void apply(const sim::Command& command, sim::ModuleWork& work) const override;
  /// Returns a small cross where the slices intersect.
  sim::Overlays overlays(const sim::OperationState& operation) const override;
};

}  // namespace trephine::ct_viewer
