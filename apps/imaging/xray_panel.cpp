#include "apps/imaging/xray_panel.h"

#include <cmath>
#include <glm/geometric.hpp>

#include "apps/workbench/text.h"

namespace trephine::imaging {

using fluoroscopy::Border;
using fluoroscopy::View;
using glm::dvec2;
using glm::dvec3;

Panel xray_panel(std::span<const float> received, const View& view, double pixel,
                 const fluoroscopy::Display& display, std::span<const std::uint8_t> hidden) {
  const std::vector<std::uint8_t> grey = fluoroscopy::show(received, view, display, hidden);
  Panel panel;
  panel.columns = view.columns, panel.rows = view.rows, panel.mm_per_pixel = pixel;
  panel.pixels.reserve(grey.size());
  for (int row = view.rows - 1; row >= 0; --row)
    for (int column = 0; column < view.columns; ++column) {
      const std::uint8_t g = grey[static_cast<std::size_t>(column) +
                                  static_cast<std::size_t>(view.columns) * static_cast<std::size_t>(row)];
      panel.pixels.push_back({g, g, g});
    }
  set_letters(panel, view.right, -view.down);
  return panel;
}

bool shows_sides(const View& view) noexcept { return std::abs(view.right.x) > 0.5 * glm::length(view.right); }

std::optional<dvec2> project_to_panel(const View& view, double pixel, const dvec3& world) {
  const auto at = view.project(world);
  if (!at) return std::nullopt;
  return dvec2(pixel * (at->x - 0.5 * (view.columns - 1)), -pixel * (at->y - 0.5 * (view.rows - 1)));
}

void draw_plan(Panel& panel, const volume::SurgicalPlan& plan, const View& view, double pixel) {
  for (const volume::PlannedTrajectory& t : plan.trajectories) {
    const auto from = project_to_panel(view, pixel, t.entry_world),
               to = project_to_panel(view, pixel, t.target_world);
    if (from && to) add_trajectory(panel, *from, *to, t.name);
  }
  for (const volume::PlannedLandmark& l : plan.landmarks) {
    const auto at = project_to_panel(view, pixel, l.position_world);
    if (!at) continue;
    const double r = 0.006 * pixel * view.columns;
    panel.lines.push_back({{*at - dvec2(r, 0), *at + dvec2(0, r), *at + dvec2(r, 0), *at - dvec2(0, r)},
                           k_plan_colour,
                           true,
                           "landmark",
                           true});
    panel.labels.push_back({*at, l.name, k_plan_colour, false, r});
  }
  for (const volume::PlannedOutline& o : plan.outlines) {
    Panel::Line line{{}, k_plan_colour, true, o.name, true};
    for (const dvec3& p : o.points_world)
      if (const auto at = project_to_panel(view, pixel, p)) line.points.push_back(*at);
    if (line.points.size() == o.points_world.size()) panel.lines.push_back(std::move(line));
  }
}

std::vector<fluoroscopy::XrayObject> xray_objects(const Subject& subject, double energy) {
  std::vector<fluoroscopy::XrayObject> objects;
  for (const Object& object : subject.objects)
    if (object.matter != volume::Matter::scenery)
      objects.push_back(
          {object.tree, object.placement, fluoroscopy::attenuation(object.matter, energy), object.is_piece});
  return objects;
}

Result<Panel> XrayCamera::shoot(const Subject& subject, const fluoroscopy::CArm& arm, int threads,
                                const fluoroscopy::Display& display) {
  if (scan_ != subject.scan || !xray_) {
    scan_ = subject.scan;
    xray_ = std::make_unique<fluoroscopy::VolumeXray>(scan_, k_energy, threads);
    beyond_.clear();
  }
  const View view(arm);
  const auto objects = xray_objects(subject, k_energy);
  if (Status error = xray_->project(view, subject.version, objects, volume::RaySum::joseph, threads))
    return *error;
  if (!(arm == arm_) || beyond_.empty()) {
    arm_ = arm;
    beyond_ = xray_->sums_outside(view, threads);
    hidden_.clear();
    for (const Border border : xray_->borders(view)) hidden_.push_back(border == Border::end);
  }
  std::vector<double> sums = xray_->sums();
  for (std::size_t i = 0; i < sums.size(); ++i) sums[i] += beyond_[i];
  const std::vector<float> received = fluoroscopy::receive(sums, view, 1, {}, threads);
  Panel panel = xray_panel(received, view, arm.pixel, display, hidden_);
  panel.title =
      workbench::format_text("X-ray: primary %.0f\u00b0, secondary %.0f\u00b0", arm.primary, arm.secondary);
  if (subject.plan) draw_plan(panel, *subject.plan, view, arm.pixel);
  return panel;
}

fluoroscopy::VolumeXray::Counters XrayCamera::counters() const {
  return xray_ ? xray_->counters() : fluoroscopy::VolumeXray::Counters{};
}

}  // namespace trephine::imaging
