#include "modules/ct_viewer/ct_viewer.h"

#include <array>
#include <cmath>

#include "sim/work.h"

namespace trephine::ct_viewer {

using glm::dvec3;
using sim::field;

std::span<const sim::ValueType* const> CtViewer::commands() const {
  static const std::array all{&sim::value_type<LookAt>(), &sim::value_type<SetGreyWindow>()};
  return all;
}

volume::Status CtViewer::allows(const sim::Command& command, const sim::OperationState&) const {
  const auto* look = command.what.as<LookAt>();
  if (look == nullptr) return std::nullopt;
  constexpr double k_far = 1e4;  // mm
  for (int a = 0; a < 3; ++a)
    if (!(std::abs(look->at[a]) <= k_far))
      return volume::Error{"the place is too far away", "look-at at", std::to_string(look->at[a]),
                           "at most 10000 mm", ""};
  return std::nullopt;
}

void CtViewer::apply(const sim::Command& command, sim::ModuleWork& work) const {
  auto& kept = work.change_settings<CtViewerState>();
  if (const auto* look = command.what.as<LookAt>()) kept.at = look->at, kept.is_looking = true;
  if (const auto* window = command.what.as<SetGreyWindow>())
    kept.level = window->level, kept.width = window->width, kept.is_window = true;
}

sim::Overlays CtViewer::overlays(const sim::OperationState& now) const {
  const auto* kept = now.settings_of<CtViewerState>();
  if (kept == nullptr || !kept->is_looking) return {};
  sim::Overlay cross;
  cross.kind = sim::Overlay::Kind::plan;
  constexpr double k_half = 6;  // mm
  for (int a = 0; a < 3; ++a) {
    dvec3 along(0.0);
    along[a] = k_half;
    cross.lines.push_back({kept->at - along, kept->at + along});
  }
  return {cross};
}

const sim::Schema& LookAt::schema() {
  static constexpr sim::Field fields[] = {
      field<&LookAt::at>("at", {.unit = "mm", .help = "in the world: slices go through here"})};
  static constexpr sim::Schema table{"look-at", 1, fields};
  return table;
}

const sim::Schema& SetGreyWindow::schema() {
  static constexpr sim::Field fields[] = {
      field<&SetGreyWindow::level>("level", {.low = -32768, .high = 32767, .help = "the window's middle"}),
      field<&SetGreyWindow::width>("width", {.low = 1, .high = 65535, .help = "from black to white"})};
  static constexpr sim::Schema table{"grey-window", 1, fields};
  return table;
}

const sim::Schema& CtViewerState::schema() {
  static constexpr sim::Field fields[] = {
      field<&CtViewerState::level>("level"), field<&CtViewerState::width>("width"),
      field<&CtViewerState::at>("at", {.unit = "mm"}), field<&CtViewerState::is_looking>("is_looking"),
      field<&CtViewerState::is_window>("is_window")};
  static constexpr sim::Schema table{"ct-viewer-state", 1, fields};
  return table;
}

}  // namespace trephine::ct_viewer
