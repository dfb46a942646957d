#include "modules/ct_viewer/ct_viewer.h"

#include <array>
#include <cmath>

#include "sim/api/work.h"

namespace trephine::ct_viewer {

using glm::dvec3;
using sim::field;

std::span<const sim::ValueType* const> CtViewer::commands() const {
  static const std::array all{&sim::value_type<LookAt>(), &sim::value_type<SetGreyWindow>()};
  return all;
}

Status CtViewer::allows(const sim::Command& command, const sim::OperationState&) const {
  const auto* request = command.request.as<LookAt>();
  if (request == nullptr) return std::nullopt;
  constexpr double k_far = 1e4;  // mm
  for (int a = 0; a < 3; ++a)
    if (!(std::abs(request->at[a]) <= k_far))
      return Error{.what = "the position is too far away",
                   .where = "look-at at",
                   .found = std::to_string(request->at[a]),
                   .expected = "coordinates within 10000 mm",
                   .remedy = "choose a position in the scan"};
  return std::nullopt;
}

void CtViewer::apply(const sim::Command& command, sim::ModuleWork& work) const {
  auto& settings = work.change_settings<CtViewerState>();
  if (const auto* request = command.request.as<LookAt>())
    settings.at = request->at, settings.has_position = true;
  if (const auto* window = command.request.as<SetGreyWindow>())
    settings.level = window->level, settings.width = window->width, settings.has_grey_window = true;
}

sim::Overlays CtViewer::overlays(const sim::OperationState& operation) const {
  const auto* settings = operation.persistent_of<CtViewerState>();
  if (settings == nullptr || !settings->has_position) return {};
  sim::Overlay cross;
  cross.kind = sim::Overlay::Kind::plan;
  constexpr double k_half = 6;  // mm
  for (int a = 0; a < 3; ++a) {
    dvec3 along(0.0);
    along[a] = k_half;
    cross.lines.push_back({settings->at - along, settings->at + along});
  }
  return {cross};
}

const sim::Schema& LookAt::schema() {
  static constexpr sim::Field fields[] = {
      field<&LookAt::at>("at", {.unit = "mm", .help = "position of the slices, world frame"})};
  static constexpr sim::Schema table{"look-at", 1, fields};
  return table;
}

const sim::Schema& SetGreyWindow::schema() {
  static constexpr sim::Field fields[] = {
      field<&SetGreyWindow::level>("level", {.low = -32768, .high = 32767, .help = "centre of the window"}),
      field<&SetGreyWindow::width>(
          "width", {.low = 1, .high = 65535, .help = "width of the window, from black to white"})};
  static constexpr sim::Schema table{"grey-window", 1, fields};
  return table;
}

const sim::Schema& CtViewerState::schema() {
  static constexpr sim::Field fields[] = {
      field<&CtViewerState::level>("level"), field<&CtViewerState::width>("width"),
      field<&CtViewerState::at>("at", {.unit = "mm"}), field<&CtViewerState::has_position>("has_position"),
      field<&CtViewerState::has_grey_window>("has_grey_window")};
  static constexpr sim::Schema table{"ct-viewer-state", 1, fields};
  return table;
}

}  // namespace trephine::ct_viewer
