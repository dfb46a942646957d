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

/// Returns the problem of a pane in two lines: what is wrong, and the remedy.
std::string problem_text(const Error& error) {
  std::string text = error.what;
  if (!error.found.empty()) text += " (" + error.found + ")";
  return error.remedy.empty() ? text : text + "\n" + error.remedy;
}

}  // namespace

/// Requests an image of the current state; the worker uses immutable copies.
void Panes::request(std::size_t index) {
  Pane& pane = panes_[index];
  pane.image.is_stale = false;
  if (pane.kind == PaneKind::rendering) return request_rendering(index);
  if (pane.kind == PaneKind::depths) {
    worker_.request(
        index,
        [depths = subject_.depths, columns = pane.columns, rows = pane.rows] {
          return depth_panel(depths, columns, rows);
        },
        pane.image.stamp);
    return;
  }
  const ImagePlane plane = plane_of(pane);
  if (pane.kind == PaneKind::section) {
    if (!subject_.bone) {
      pane.image.problem = "The section needs the shape of bone. Choose a range of values or a label.",
      ++pane.changes;
      return;
    }
    worker_.request(
        index,
        [subject = subject_, plane]() -> Result<Panel> {
          const auto objects = section_objects(subject, plane);
          if (!objects) return objects.error();
          SectionAreas areas;
          Panel panel = section_panel(objects.value(), section_tissues(subject, plane), plane, areas);
          panel.foot = areas.models > 0 ? format_text("models %.0f mm\u00b2, outside bone %.0f", areas.models,
                                                      areas.outside)
                                        : "";
          return panel;
        },
        pane.image.stamp);
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
      pane.image.stamp);
}

void Panes::request_xray() {
  const bool is_shot = std::exchange(xray_.is_requested, false);
  xray_.is_stale = false;
  ++xray_.changes;
  if (!subject_.scan->is_hounsfield) {
    xray_.problem = "X-rays need a scan in Hounsfield units. Open a CT.";
    return;
  }
  if (!xray_.camera) xray_.camera = std::make_shared<XrayCamera>();
  xray_.is_computing = true;
  const fluoroscopy::CArm arm = with_columns(arm_, is_shot ? k_shot_pixels : k_live_pixels);
  Subject exposed = subject_;
  if (xray_tool_) exposed.objects.push_back(*xray_tool_);
  worker_.request(
      panes_.size(),
      [camera = xray_.camera, subject = std::move(exposed), arm] {
        Result<Panel> panel = camera->shoot(subject, arm, k_threads);
        if (panel) panel.value().shows_sides = shows_sides(fluoroscopy::View(arm));
        return panel;
      },
      xray_.stamp);
}

/// Requests a ray-cast image: during motion with as many pixels as 60 ms allow, at rest with all pixels.
void Panes::request_rendering(std::size_t index) {
  Pane& pane = panes_[index];
  if (!has_camera_) return;
  if (!pane.renderer) {
    pane.renderer = std::make_shared<Renderer>();
    pane.renderer->set_transfer_function(transfer(*subject_.scan));
    pane.renderer->set_labels(appearances_);
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
  request.camera = camera_;
  request.openings.plane = clip_;
  request.camera.columns =
      std::max(1, static_cast<int>(std::lround(pane.columns * (pane.is_coarse ? share : 1))));
  request.camera.rows = std::max(1, static_cast<int>(std::lround(pane.rows * (pane.is_coarse ? share : 1))));
  if (const Status error = volume::check(request.camera)) {
    pane.image.is_stale = pane.is_coarse = false;
    pane.image.problem = problem_text(*error), ++pane.changes;
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
      pane.image.stamp);
}

bool Panes::adopt(std::size_t slot, Image& image) {
  auto result = worker_.take(slot);
  if (!result || result->stamp != image.stamp) return false;
  if (result->panel && result->panel.value().pixels.empty()) {  // cancelled
    // If a newer request replaced the cancelled one, its own flag is still false, and its image will follow.
    image.is_stale = image.is_stale || (slot < panes_.size() && *panes_[slot].is_cancelled);
    return false;
  }
  ++image.changes, ++image.count;
  image.milliseconds = result->milliseconds;
  image.problem = result->panel ? "" : problem_text(result->panel.error());
  if (result->panel) image.panel = std::move(result->panel).value();
  if (image.panel) show_side(*image.panel);
  return true;
}

bool Panes::adopt_xray() {
  if (!adopt(panes_.size(), xray_)) return false;
  xray_.is_computing = false;
  if (xray_.panel) xray_.panel->title = is_live_ ? "X-ray, live" : "X-ray, held";
  return true;
}

bool Panes::frame() {
  bool is_new = false;
  for (std::size_t i = 0; i < panes_.size(); ++i) {
    Pane& pane = panes_[i];
    if (!adopt(i, pane.image)) continue;
    is_new = true;
    if (pane.kind == PaneKind::rendering && pane.image.panel && pane.image.milliseconds > 0)
      pixels_per_ms_ = static_cast<double>(pane.image.panel->pixels.size()) / pane.image.milliseconds;
  }
  is_new |= adopt_xray();
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
    if (pane.is_coarse && pane.kind == PaneKind::rendering &&
        std::chrono::steady_clock::now() - pane.requested > std::chrono::milliseconds(300))
      pane.image.is_stale = true;
  bool has_stale = is_xray_due();
  for (const Pane& pane : panes_)
    has_stale |= pane.image.is_stale && pane.is_visible && pane.kind != PaneKind::xray;
  for (std::size_t i = 0; i < panes_.size(); ++i) {
    Pane& pane = panes_[i];
    // Cancel a slow ray-cast image if any pane needs a new image, or if the pane of the slow image is hidden.
    if (pane.is_cancelled && (has_stale || !pane.is_visible)) *pane.is_cancelled = true;
    if (pane.image.is_stale && pane.is_visible && pane.kind != PaneKind::xray && pane.columns > 1 &&
        pane.rows > 1)
      request(i);
  }
  if (is_xray_due()) request_xray();
  return is_new;
}

bool Panes::is_waiting() const {
  for (std::size_t i = 0; i < panes_.size(); ++i) {
    const Pane& pane = panes_[i];
    const Image& image = pane.image;
    if (!pane.is_visible || pane.kind == PaneKind::xray) continue;
    const bool is_requested = image.is_stale || worker_.is_busy(i);
    if (!image.panel) {
      if (is_requested || image.problem.empty()) return true;
      continue;
    }
    if (pane.kind == PaneKind::rendering && (is_requested || pane.is_coarse)) return true;
    // Depth images have a size of their own.
    const bool has_size = image.panel->columns == pane.columns && image.panel->rows == pane.rows;
    if (is_requested && !has_size && pane.kind != PaneKind::depths) return true;
  }
  return is_exposing();
}

bool Panes::is_up_to_date() const {
  for (const Pane& pane : panes_)
    if (pane.is_visible && pane.kind != PaneKind::xray && (pane.image.is_stale || pane.is_coarse))
      return false;
  return !is_xray_due() && worker_.is_idle();
}

}  // namespace trephine::imaging
