#include "apps/imaging/panes.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

namespace trephine::imaging {

using glm::dvec2;
using glm::dvec3;
using volume::ImagePlane;

namespace {

dvec3 middle_of(const volume::Volume& scan) {
  return scan.frame.world_from_volume(0.5 * (dvec3(scan.size) - 1.0));
}

}  // namespace

Panes::Panes(std::size_t count) : panes_(count), worker_(count + 1) {
  constexpr PaneKind first[] = {PaneKind::axial, PaneKind::coronal, PaneKind::sagittal};
  for (std::size_t i = 0; i < count; ++i) panes_[i].kind = first[i % 3];
}

void Panes::show(Subject subject, bool is_changed) {
  const bool is_new_scan = subject.scan != subject_.scan;
  if (is_new_scan) forget();
  is_changed |= is_new_scan || subject.objects.size() != subject_.objects.size();
  for (std::size_t i = 0; !is_changed && i < subject.objects.size(); ++i)
    is_changed = subject.objects[i].tree != subject_.objects[i].tree ||
                 !(subject.objects[i].placement == subject_.objects[i].placement);
  is_changed |= subject.version != subject_.version;
  const auto is_newer = [&](std::size_t i) { return subject.depths[i].set != subject_.depths[i].set; };
  bool has_newer_depths = subject.depths.size() != subject_.depths.size();
  for (std::size_t i = 0; !has_newer_depths && i < subject.depths.size(); ++i) has_newer_depths = is_newer(i);
  const bool is_other_bone = subject.bone.has_value() != subject_.bone.has_value() ||
                             (subject.bone && subject.bone->low != subject_.bone->low);
  subject_ = std::move(subject);
  if (is_other_bone) set_transfer_function(transfer_);
  if (is_new_scan && subject_.scan) {
    at_ = middle_of(*subject_.scan);
    if (!has_arm_) arm_.isocentre = at_;
  }
  if (is_changed) make_stale(is_live_);
  for (Pane& pane : panes_)
    if (pane.kind == PaneKind::depths) pane.image.is_stale |= has_newer_depths;
}

/// Discards all images of a pane, finished or in progress.
void Panes::forget(std::size_t index) {
  Pane& pane = panes_[index];
  worker_.forget(index);
  if (pane.is_cancelled) *pane.is_cancelled = true;
  pane.renderer.reset();
  pane.is_coarse = false;
  const std::uint64_t stamp = pane.image.stamp + 1;
  pane.image = {};
  pane.image.stamp = stamp;
  ++pane.changes;
}

void Panes::clear_xray() {
  worker_.forget(panes_.size());
  const std::uint64_t stamp = xray_.stamp + 1, changes = xray_.changes + 1;
  xray_ = {};
  xray_.stamp = stamp, xray_.changes = changes;
  xray_note_.clear();
}

void Panes::forget() {
  for (std::size_t i = 0; i < panes_.size(); ++i) forget(i), panes_[i].pixel = 0;
  clear_xray();
  has_window_ = has_arm_ = is_live_ = false;
  xray_note_.clear(), appearances_.clear();
  subject_ = {};
  arm_ = {};
}

bool Panes::shows(PaneKind kind) const noexcept {
  for (const Pane& pane : panes_)
    if (pane.kind == kind && pane.is_visible) return true;
  return false;
}

/// Marks images as stale. An X-ray shows the state at its exposure, and only a live X-ray is taken again
/// after changes.
void Panes::make_stale(bool includes_xrays) {
  for (Pane& pane : panes_)
    if (pane.kind != PaneKind::depths) pane.image.is_stale = true;
  xray_.is_stale |= includes_xrays;
}

void Panes::make_slices_stale(bool includes_sections) {
  for (Pane& pane : panes_)
    pane.image.is_stale |=
        pane.kind <= PaneKind::tool || (includes_sections && pane.kind == PaneKind::section);
}

void Panes::set_focus(const dvec3& world) {
  if (world == at_) return;
  at_ = world;
  make_slices_stale(true);
}

void Panes::show_tool(const dvec3& tip, const dvec3& shaft) {
  if (tip == tip_ && shaft == shaft_) return;
  tip_ = tip, shaft_ = shaft;
  for (Pane& pane : panes_)
    if (pane.kind == PaneKind::tool) pane.image.is_stale = true;
}

void Panes::turn_section(const dvec3& normal) {
  if (!(glm::length(normal) > 1e-9) || glm::normalize(normal) == section_normal_) return;
  section_normal_ = glm::normalize(normal);
  make_slices_stale(true);
}

std::optional<int> Panes::probe() const {
  if (!subject_.scan) return std::nullopt;
  ImagePlane pixel;
  pixel.columns = pixel.rows = 1, pixel.middle_world = at_;
  const ct_viewer::SliceValues values =
      ct_viewer::slice_values(*subject_.scan, *subject_.version, pixel, {}, 1);
  return values.before[0] == ct_viewer::k_outside ? std::nullopt : std::optional<int>(values.now[0]);
}

void Panes::set_kind(std::size_t index, PaneKind kind) {
  Pane& pane = panes_[index];
  if (pane.kind == kind) return;
  pane.kind = kind;
  forget(index);
  reset(index);
}

void Panes::set_from_back(bool is_from_back) {
  if (is_from_back_ == is_from_back) return;
  is_from_back_ = is_from_back;
  for (Pane& pane : panes_)
    if (is_planar(pane.kind)) pane.image.is_stale = true;
  if (xray_.panel) show_side(*xray_.panel), ++xray_.changes;
}

/// Mirrors an X-ray if its sides do not match the selected view.
void Panes::show_side(Panel& panel) const {
  if (!panel.shows_sides || panel.is_mirrored == is_from_back_) return;
  mirror(panel);
  panel.is_mirrored = is_from_back_;
}

bool Panes::is_mirrored(const fluoroscopy::View& view) const noexcept {
  return is_from_back_ && shows_sides(view);
}

void Panes::set_size(std::size_t index, int columns, int rows, bool is_visible) {
  Pane& pane = panes_[index];
  if (pane.columns == columns && pane.rows == rows && pane.is_visible == is_visible) return;
  pane.image.is_stale |= is_visible && (pane.columns != columns || pane.rows != rows || !pane.is_visible);
  pane.columns = columns, pane.rows = rows;
  pane.is_visible = is_visible;
}

void Panes::scroll(std::size_t index, int slices) {
  const auto image_plane = plane(index);
  if (!image_plane) return;
  // One step is the distance of the scan's slices along the voxel axis that is nearest to the normal.
  const dvec3 n = image_plane->normal(), step = subject_.scan->frame.vector_volume_from_world(n);
  const double largest_step = std::max({std::abs(step.x), std::abs(step.y), std::abs(step.z)});
  set_focus(at_ + slices / largest_step * n);
}

void Panes::zoom(std::size_t index, double factor, const dvec2& around) {
  Pane& pane = panes_[index];
  const auto before = plane(index);
  if (!before) return;
  const dvec3 anchor = before->world(around.x, around.y);
  pane.middle = before->middle_world;
  pane.pixel = std::clamp(before->pixel / factor, 0.01, 5.0);
  const dvec3 moved = plane(index)->world(around.x, around.y);
  pane.middle += anchor - moved;
  pane.image.is_stale = true;
}

void Panes::pan(std::size_t index, const dvec2& pixels) {
  Pane& pane = panes_[index];
  const auto before = plane(index);
  if (!before) return;
  pane.pixel = before->pixel;
  pane.middle = before->middle_world - before->pixel * (pixels.x * before->right - pixels.y * before->up);
  pane.image.is_stale = true;
}

void Panes::reset(std::size_t index) {
  panes_[index].pixel = 0;
  panes_[index].image.is_stale = true;
}

void Panes::set_window(const ct_viewer::GreyWindow& window) {
  has_window_ = true;
  window_ = {window.level, std::max(1.0, window.width)};
  make_slices_stale();
}

void Panes::set_blend(ct_viewer::Blend blend) {
  blend_ = blend;
  make_slices_stale();
}

void Panes::set_labels(bool are_shown) {
  has_labels_ = are_shown;
  make_slices_stale();
}

void Panes::set_slab(double thickness) {
  slab_ = std::clamp(thickness, 0.0, 100.0);
  make_slices_stale();
}

void Panes::set_camera(const volume::Camera& camera, const std::optional<volume::Openings::Plane>& clip) {
  const bool is_same = has_camera_ && camera.at == camera_.at && camera.forward == camera_.forward &&
                       camera.up == camera_.up && camera.height == camera_.height &&
                       camera.distance == camera_.distance && clip.has_value() == clip_.has_value() &&
                       (!clip || (clip->at == clip_->at && clip->normal == clip_->normal));
  if (is_same) return;
  camera_ = camera, clip_ = clip, has_camera_ = true;
  for (Pane& pane : panes_)
    if (pane.kind == PaneKind::rendering) pane.image.is_stale = true;
}

void Panes::set_transfer_function(std::string_view name) {
  if (name != transfer_) transfer_ = name;
  for (Pane& pane : panes_)
    if (pane.kind == PaneKind::rendering) {
      if (pane.is_cancelled) *pane.is_cancelled = true;
      pane.renderer.reset(), pane.image.is_stale = true;
    }
}

volume::TransferFunction Panes::transfer(const volume::Volume& scan) const {
  const auto& bone = subject_.bone;
  const bool is_threshold = bone && !bone->is_label() && std::isfinite(bone->low) && std::isinf(bone->high);
  return transfer_function_of(transfer_, scan, is_threshold ? bone->low : k_bone);
}

void Panes::set_label_opacity(std::size_t label, double opacity) {
  appearances_.resize(std::max(appearances_.size(), label + 1));
  appearances_[label].opacity = opacity;
  set_transfer_function(transfer_);  // redraws
}

void Panes::set_arm(const fluoroscopy::CArm& arm) {
  if (has_arm_ && arm_ == arm) return;
  arm_ = arm, has_arm_ = true;
  if (is_live_) make_stale(true);
}

void Panes::set_live(bool is_live) {
  if (is_live_ == is_live) return;
  is_live_ = is_live;
  if (is_live)
    xray_.is_stale = true;
  else if (xray_.panel)
    xray_.panel->title = "X-ray, held", ++xray_.changes;
}

void Panes::shoot() {
  xray_.is_requested = true;
  ++xray_.changes;
}

/// Returns the plane of a planar pane, in the pane's own pixels.
ImagePlane Panes::plane_of(const Pane& pane) const {
  ImagePlane plane;
  plane.columns = std::max(1, pane.columns), plane.rows = std::max(1, pane.rows);
  dvec3 through = at_;
  if (pane.kind == PaneKind::section) {
    orient_plane(plane, section_normal_);
  } else if (pane.kind == PaneKind::tool) {
    // The plane contains the shaft. It is viewed as nearly from the patient's left as possible, or from the
    // front if the shaft is almost along the left-right axis.
    through = tip_;
    const dvec3 request = std::abs(shaft_.x) < 0.9 ? dvec3(1, 0, 0) : dvec3(0, -1, 0);
    orient_plane(plane, request - glm::dot(request, shaft_) * shaft_);
  } else {
    orient_plane(plane, k_pane_kinds[static_cast<std::size_t>(pane.kind)]);
  }
  if (is_from_back_ && plane.right.x > 0.5) {
    if (std::abs(plane.normal().z) > 0.7) plane.up = -plane.up;
    plane.right = -plane.right;
  }
  // Fit the whole scan, unless a pixel size was chosen.
  dvec2 low(1e300), high(-1e300);
  for (const dvec3& corner :
       volume::corners_world(subject_.scan->frame, glm::ivec3(0), subject_.scan->size - 1)) {
    const dvec2 p = plane.from_world(corner);
    low = glm::min(low, p), high = glm::max(high, p);
  }
  if (pane.pixel > 0) {
    plane.pixel = pane.pixel;
    plane.middle_world = pane.middle;
  } else {
    plane.pixel =
        std::clamp(std::max((high.x - low.x) / plane.columns, (high.y - low.y) / plane.rows), 0.01, 5.0);
    plane.middle_world = plane.world(0.5 * (low + high));
  }
  const dvec3 n = plane.normal();
  plane.middle_world += glm::dot(through - plane.middle_world, n) * n;
  return plane;
}

std::optional<ImagePlane> Panes::plane(std::size_t index) const {
  const Pane& pane = panes_[index];
  if (!subject_.scan || !is_planar(pane.kind)) return std::nullopt;
  return plane_of(pane);
}

std::optional<dvec3> Panes::world(std::size_t index, const dvec2& pixel) const {
  const auto image_plane = plane(index);
  return image_plane ? std::optional<dvec3>(image_plane->world(pixel.x, pixel.y)) : std::nullopt;
}

std::optional<dvec2> Panes::pixel(std::size_t index, const dvec3& world) const {
  const Pane& pane = panes_[index];
  if (!subject_.scan) return std::nullopt;
  if (const auto image_plane = plane(index)) {
    const dvec2 mm = image_plane->from_world(world);
    return dvec2(mm.x / image_plane->pixel + 0.5 * (image_plane->columns - 1),
                 0.5 * (image_plane->rows - 1) - mm.y / image_plane->pixel);
  }
  if (pane.kind != PaneKind::xray) return std::nullopt;
  // The X-ray fills the pane.
  const fluoroscopy::View view(arm_);
  const auto at = view.project(world);
  if (!at || pane.columns < 2) return std::nullopt;
  const double sign = is_mirrored(view) ? -1 : 1;
  const double scale =
      std::min(pane.columns / static_cast<double>(view.columns), pane.rows / static_cast<double>(view.rows));
  return dvec2(sign * scale * (at->x - 0.5 * (view.columns - 1)) + 0.5 * (pane.columns - 1),
               scale * (at->y - 0.5 * (view.rows - 1)) + 0.5 * (pane.rows - 1));
}

const Panel* Panes::panel(std::size_t index) const noexcept {
  const Image& image = image_of(index);
  return image.panel ? &*image.panel : nullptr;
}

}  // namespace trephine::imaging
