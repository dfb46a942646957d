// Place in a scan and grey values of the viewer: kept with an operation, so that a replay
// looks there too.
#pragma once

#include "modules/ct_viewer/grey_window.h"
#include "sim/module.h"

namespace trephine::ct_viewer {

/// A command: slices go through here.
struct LookAt {
  glm::dvec3 at{0.0};  ///< mm, world
  static const sim::Schema& schema();
};

/// A command: greys are of this window.
struct SetGreyWindow : GreyWindow {
  static const sim::Schema& schema();
};

/// Settings of the viewer. Undo leaves them alone.
struct CtViewerState : GreyWindow {
  glm::dvec3 at{0.0};
  bool is_looking = false;  ///< a place was chosen
  bool is_window = false;   ///< a grey window was chosen
  static const sim::Schema& schema();
};

class CtViewer final : public sim::Module {
 public:
  std::string_view name() const noexcept override { return "ct_viewer"; }
  std::span<const sim::ValueType* const> commands() const override;
  sim::Value settings() const override { return CtViewerState{}; }
  volume::Status allows(const sim::Command& command, const sim::OperationState& now) const override;
  void apply(const sim::Command& command, sim::ModuleWork& work) const override;
  /// A small cross where the slices meet.
  sim::Overlays overlays(const sim::OperationState& now) const override;
};

}  // namespace trephine::ct_viewer
