// Drawing of bone flaps: the cut outline, the planned one with its anchors, a preview and its problem.
#include <algorithm>
#include <glm/geometric.hpp>
#include <string>

#include "modules/bone_flap/bone_flap.h"
#include "modules/bone_flap/freehand.h"
#include "modules/bone_flap/outline.h"
#include "modules/bone_flap/preview.h"

namespace trephine::bone_flap {

using glm::dvec3;

namespace {

/// Breaks a label into lines of at most k_longest characters, unless a word is longer. Such lines are about
/// as wide as the head in a picture.
std::string wrap_label(std::string text) {
  constexpr std::size_t k_longest = 36;
  for (std::size_t begin = 0; text.size() - begin > k_longest;) {
    const std::size_t space = text.rfind(' ', begin + k_longest);
    if (space == std::string::npos || space <= begin) break;
    text[space] = '\n';
    begin = space + 1;
  }
  return text;
}

/// Returns true if a flap was cut by hand where the outline was drawn: outline and preview would then cover
/// the opening. Another outline stays visible.
bool is_cut_by_hand(const FlapSettings& settings, const sim::OperationState& operation) {
  const sim::Body* piece = freehand_piece(operation);
  if (piece == nullptr) return false;
  if (settings.anchors.empty()) return true;  // an outline of the plan, shown by its preview
  dvec3 middle(0);
  for (const dvec3& anchor : settings.anchors)
    middle += anchor / static_cast<double>(settings.anchors.size());
  constexpr double k_same = 30;  // mm
  return glm::length(middle - piece->piece->middle_world) < k_same;
}

}  // namespace

sim::Overlays BoneFlap::overlays(const sim::OperationState& operation) const {
  sim::Overlays result;
  const auto add_loop = [](sim::Overlay& overlay, const std::vector<dvec3>& points) {
    for (std::size_t i = 0; i < points.size(); ++i)
      overlay.lines.push_back({points[i], points[(i + 1) % points.size()]});
  };
  if (const FlapState* state = operation.undoable_of<FlapState>(); state && state->flaps > 0)
    add_loop(result.emplace_back(), state->outline);
  const FlapSettings* settings = operation.persistent_of<FlapSettings>();
  if (settings == nullptr || is_cut_by_hand(*settings, operation)) return result;
  // Straight sides would be hidden in the round skull, so they are drawn as arcs, lifted away from the scan's
  // centre.
  const volume::Volume& scan = operation.undoable.version->base();
  const dvec3 middle = scan.frame.world_from_volume(0.5 * dvec3(scan.size - 1));
  const auto lift = [&](const dvec3& p, double height) {
    const double distance = glm::length(p - middle);
    return distance > 0 ? p + height / distance * (p - middle) : p;
  };
  const auto add_sides = [&](sim::Overlay& overlay, const std::vector<dvec3>& anchors) {
    constexpr int k_parts = 8;
    constexpr double k_height = 1.5, k_radius = 70;  // mm
    std::vector<dvec3> points;
    for (std::size_t i = 0; i < anchors.size(); ++i) {
      const dvec3 side = anchors[(i + 1) % anchors.size()] - anchors[i];
      for (int k = 0; k < k_parts; ++k) {
        const double share = static_cast<double>(k) / k_parts;
        const double rise = share * (1 - share) * glm::dot(side, side) / (2 * k_radius);
        points.push_back(lift(anchors[i] + share * side, k_height + rise));
      }
    }
    add_loop(overlay, points);
  };
  if (!settings->anchors.empty()) {
    sim::Overlay& plan = result.emplace_back();
    if (settings->anchors.size() > 1) add_sides(plan, settings->anchors);
    for (std::size_t i = 0; i < settings->anchors.size(); ++i) {
      plan.labels.push_back({lift(settings->anchors[i], 2), std::to_string(i + 1)});
      plan.handles.push_back({settings->anchors[i], MoveAnchor{static_cast<std::int64_t>(i) + 1}});
    }
  }
  const FlapPreview* preview = operation.result_of<FlapPreview>();
  if (preview == nullptr) return result;
  if (!preview->summary.empty()) result.push_back(preview_overlay(*preview));
  // Without anchors, the problem has no location to draw; the event FlapFailed or FlapPreviewed reports it.
  if (preview->problem.empty() || preview->failed_anchors.empty()) return result;
  // A cross marks the location of the problem. If the failed outline is not the drawn one, its sides are
  // drawn, too.
  sim::Overlay& warning = result.emplace_back();
  warning.kind = sim::Overlay::Kind::warning;
  if (preview->failed_anchors != settings->anchors) add_sides(warning, preview->failed_anchors);
  const dvec3& problem_at = preview->problem_at;
  const dvec3 cross = lift(problem_at, 2);
  if (const double distance = glm::length(problem_at - middle); distance > 0) {
    constexpr double k_arm = 3;  // mm
    dvec3 right, up;
    set_orthogonal_axes((problem_at - middle) / distance, right, up);
    for (const dvec3& arm : {right + up, right - up})
      warning.lines.push_back({cross - k_arm * arm, cross + k_arm * arm});
  }
  // A problem away from all anchors may be deep in the bone: a line leads from its position to the label.
  const bool is_anchor =
      std::any_of(preview->failed_anchors.begin(), preview->failed_anchors.end(),
                  [&](const dvec3& anchor) { return glm::length(anchor - problem_at) < k_anchor_spacing; });
  const dvec3 label_position = is_anchor ? cross : lift(problem_at, 25);
  if (!is_anchor) warning.lines.push_back({problem_at, label_position});
  warning.labels.push_back({label_position, wrap_label(preview->problem)});
  return result;
}

}  // namespace trephine::bone_flap
