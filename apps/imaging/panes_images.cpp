// Images of Panes: requests to the worker's thread, and results from it.
#include <algorithm>
#include <cmath>

#include "apps/imaging/depth_panel.h"
#include "apps/imaging/panes.h"
#include "apps/imaging/section_panel.h"
#include "apps/workbench/text.h"

namespace trephine::imaging {

using glm::dvec3;
using volume::ImagePlane;
using workbench::format_text;

namespace {

constexpr int k_threads = 1;  // leaves the other cores to the servo and the 3-D view
constexpr int k_live_pixels = 256, k_shot_pixels = 1024;

/// Returns a C-arm with a detector of the same size and another number of pixels.
fluoroscopy::CArm with_columns(fluoroscopy::CArm arm, int columns) {
  arm.pixel *= static_cast<double>(arm.columns) / columns;
  arm.rows = std::max<std::int64_t>(
      1, std::llround(static_cast<double>(arm.rows) * columns / static_cast<double>(arm.columns)));
  arm.columns = columns;
  return arm;
}

}  // namespace

/// Requests an image of the current state; the worker uses immutable copies.
void Panes::request(std::size_t index) {
  Pane& pane = panes_[index];
  pane.is_stale = false;
  if (pane.kind == PaneKind::xray) {
    if (!subject_.scan->is_hounsfield) {
      pane.problem = "X-rays need Hounsfield units, but the scan has other values", ++pane.changes;
      return;
    }
    if (!pane.camera) pane.camera = std::make_shared<XrayCamera>();
    const bool is_shot = std::exchange(pane.is_wanted, false) || !is_live_;
    const fluoroscopy::CArm arm = with_columns(arm_, is_shot ? k_shot_pixels : k_live_pixels);
    worker_.request(
        index,
        [camera = pane.camera, subject = subject_, arm] {
          Result<Panel> panel = camera->shoot(subject, arm, k_threads);
          if (panel) panel.value().shows_sides = shows_sides(fluoroscopy::View(arm));
          return panel;
        },
        pane.stamp);
    return;
  }
  if (pane.kind == PaneKind::drawn) return request_drawn(index);
  if (pane.kind == PaneKind::depths) {
    worker_.request(
        index,
        [depths = subject_.depths, columns = pane.columns, rows = pane.rows] {
          return depth_panel(depths, columns, rows);
        },
        pane.stamp);
    return;
  }
  const ImagePlane plane = plane_of(pane);
  if (pane.kind == PaneKind::section) {
    if (!subject_.bone) {
      pane.problem = "The section needs a shape as bone. Choose a range of values or a label.",
      ++pane.changes;
      return;
    }
    worker_.request(
        index,
        [subject = subject_, plane]() -> Result<Panel> {
          const auto objects = section_objects(subject, plane);
          if (!objects) return objects.error();
          SectionAreas areas;
          Panel panel = section_panel(objects.value(), plane, areas);
          panel.foot = areas.models > 0 ? format_text("models %.0f mm\u00b2, outside bone %.0f", areas.models,
                                                      areas.outside)
                                        : "";
          return panel;
        },
        pane.stamp);
    return;
  }
  const volume::Slab slab{slab_, volume::Slab::Kind::mean};
  worker_.request(
      index,
      [subject = subject_, plane, slab, window = window_, blend = blend_, labels = has_labels_,
       kind = pane.kind]() -> Result<Panel> {
        const ct_viewer::SliceValues values =
            ct_viewer::slice_values(*subject.scan, *subject.version, plane, slab, k_threads);
        Panel panel = slice_panel(values, plane, window, blend);
        if (Status error = draw_in(panel, subject, plane, labels)) return *error;
        panel.title = kind == PaneKind::tool ? "along the tool"
                                             : std::string(k_pane_kinds[static_cast<std::size_t>(kind)]);
        panel.foot = format_text("window %.0f / %.0f", window.width, window.level);
        if (slab.thickness > 0) panel.foot += format_text(", mean of %.0f mm", slab.thickness);
        return panel;
      },
      pane.stamp);
}

/// Requests a ray-cast image: during motion with as many pixels as 60 ms allow, at rest with all pixels.
void Panes::request_drawn(std::size_t index) {
  Pane& pane = panes_[index];
  if (!has_eye_) return;
  if (!pane.renderer) {
    pane.renderer = std::make_shared<Renderer>(transfer_);
    pane.renderer->set_labels(looks_);
  }
  const auto now = std::chrono::steady_clock::now();
  const bool is_moving = now - pane.requested < std::chrono::milliseconds(250);
  pane.requested = now;
  constexpr double k_budget = 60;  // ms
  const double pixel_count = static_cast<double>(pane.columns) * pane.rows;
  const double share =
      is_moving ? std::clamp(std::sqrt(k_budget * pixels_per_ms_ / pixel_count), 0.08, 1.0) : 1.0;
  pane.is_coarse = share < 0.95;
  volume::RaycastRequest request;
  request.camera = eye_;
  request.openings.plane = clip_;
  request.camera.columns =
      std::max(1, static_cast<int>(std::lround(pane.columns * (pane.is_coarse ? share : 1))));
  request.camera.rows = std::max(1, static_cast<int>(std::lround(pane.rows * (pane.is_coarse ? share : 1))));
  if (const Status error = volume::check(request.camera)) {
    pane.is_stale = pane.is_coarse = false;
    pane.problem = error->message(), ++pane.changes;
    return;
  }
  // A full-resolution image can be cancelled for more urgent ones.
  pane.is_cancelled = std::make_shared<std::atomic<bool>>(false);
  if (!pane.is_coarse) request.is_cancelled = pane.is_cancelled.get();
  worker_.request(
      index,
      [renderer = pane.renderer, subject = subject_, request, name = transfer_,
       given_up = pane.is_cancelled]() -> Result<Panel> {
        Panel panel = renderer->draw(subject, request, k_threads);
        if (request.is_cancelled != nullptr && *given_up) return Panel();
        panel.foot = subject.scan->is_hounsfield ? name : "grey";
        return panel;
      },
      pane.stamp);
}

bool Panes::frame() {
  bool is_new = false;
  for (std::size_t i = 0; i < panes_.size(); ++i) {
    auto image = worker_.take(i);
    Pane& pane = panes_[i];
    if (!image || image->stamp != pane.stamp) continue;
    if (image->panel && image->panel.value().pixels.empty()) {  // cancelled
      pane.is_stale = pane.is_stale || *pane.is_cancelled;      // otherwise a newer request is pending
      continue;
    }
    is_new = true, ++pane.changes;
    pane.milliseconds = image->milliseconds, ++pane.made;
    pane.problem = image->panel ? "" : image->panel.error().message();
    if (image->panel) pane.panel = std::move(image->panel).value();
    if (pane.panel) show_side(*pane.panel);
    if (pane.kind == PaneKind::xray && pane.panel)
      pane.panel->title = is_live_ ? "X-ray, live" : "X-ray, held";
    if (pane.kind == PaneKind::drawn && pane.panel && image->milliseconds > 0)
      pixels_per_ms_ = static_cast<double>(pane.panel->pixels.size()) / image->milliseconds;
  }
  if (!subject_.scan) return is_new;
  if (!has_window_) {
    // For values without a unit, the middle slice determines the range.
    ImagePlane middle;
    orient_plane(middle, "axial");
    middle.middle_world = subject_.scan->frame.world_from_volume(0.5 * (dvec3(subject_.scan->size) - 1.0));
    window_ = first_window(*subject_.scan,
                           ct_viewer::slice_values(*subject_.scan, *subject_.version, middle, {}, 1).before);
    has_window_ = true;
  }
  // Draw a coarse image at full resolution after 300 ms without motion.
  for (Pane& pane : panes_)
    if (pane.is_coarse && pane.kind == PaneKind::drawn &&
        std::chrono::steady_clock::now() - pane.requested > std::chrono::milliseconds(300))
      pane.is_stale = true;
  bool has_stale = false;
  for (const Pane& pane : panes_) has_stale = has_stale || (pane.is_stale && pane.is_visible);
  for (std::size_t i = 0; i < panes_.size(); ++i) {
    Pane& pane = panes_[i];
    // Cancel a slow ray-cast image if another pane waits or if it is invisible.
    if (pane.is_cancelled && (has_stale || !pane.is_visible)) *pane.is_cancelled = true;
    if (pane.is_stale && pane.is_visible && pane.columns > 1 && pane.rows > 1) request(i);
  }
  return is_new;
}

bool Panes::is_up_to_date() const {
  for (const Pane& pane : panes_)
    if (pane.is_visible && (pane.is_stale || pane.is_coarse)) return false;
  return worker_.is_idle();
}

}  // namespace trephine::imaging
