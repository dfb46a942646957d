#include "apps/view/pane_controller.h"

#include <algorithm>
#include <cstdio>
#include <utility>

#include "apps/view/tool_appearance.h"
#include "modules/cross_section/cross_section.h"
#include "modules/ct_viewer/ct_viewer.h"
#include "modules/fluoroscopy/fluoroscopy.h"

namespace trephine::view {

using glm::dvec3;

namespace {

imaging::Subject subject_of(const PaneInput& input) {
  imaging::Subject subject;
  subject.scan = input.scene.base;
  subject.version = input.version;
  for (const haptics::TouchItem& item : input.scene.items)
    if (!subject.bone && !item.is_mesh() && &item.field.volume() == input.scene.base.get())
      subject.bone = item.field.shape();
  for (const auto& structure : input.forbidden)
    if (structure->shape()) subject.structures.push_back(*structure->shape());
  const haptics::Placement hand{input.newest.pose.position_world,
                                haptics::unit_of(input.newest.pose.orientation)};
  if (input.overlays != nullptr)
    for (const sim::Overlay& overlay : *input.overlays)
      if (overlay.surface && overlay.kind == sim::Overlay::Kind::object)
        subject.objects.push_back({overlay.name, overlay.surface,
                                   overlay.holder == 0 ? hand * overlay.grip : overlay.placement,
                                   overlay.matter, overlay.is_detached});
  subject.plan = input.plan;
  subject.depths.assign(input.depths.begin(), input.depths.end());
  return subject;
}

}  // namespace

void PaneController::begin() {
  panes_.forget();
  tool_.reset(), followed_.clear(), clip_.reset();
  shadow_instrument_ = {}, shadow_.reset();
  shots_.reset();
  is_placed_ = false, exposed_ = 0, unconfirmed_shots_ = 0;
  shown_t_ = 0;
}

/// Applies the settings that changed since the last frame.
void PaneController::follow(std::span<const std::shared_ptr<const sim::Value>> settings) {
  const bool is_first = followed_.empty();
  for (std::size_t i = 0; i < settings.size(); ++i) {
    const std::shared_ptr<const sim::Value>& current = settings[i];
    const auto previous = i < followed_.size() ? followed_[i] : nullptr;
    if (!current || current == previous) continue;
    if (const auto* viewer = current->as<ct_viewer::CtViewerState>()) {
      const auto* old_viewer = previous ? previous->as<ct_viewer::CtViewerState>() : nullptr;
      if (viewer->has_position && (!old_viewer || !old_viewer->has_position || old_viewer->at != viewer->at))
        panes_.set_focus(viewer->at);
      if (viewer->has_grey_window && (!old_viewer || !old_viewer->has_grey_window ||
                                      !(static_cast<const ct_viewer::GreyWindow&>(*old_viewer) == *viewer)))
        panes_.set_window(*viewer);
    } else if (const auto* section = current->as<cross_section::SectionPlane>()) {
      const auto* old_section = previous ? previous->as<cross_section::SectionPlane>() : nullptr;
      const bool has_changed = !old_section || old_section->at != section->at ||
                               old_section->normal != section->normal ||
                               old_section->is_clipping != section->is_clipping;
      // Skip the default section of an operation in which no section was set.
      if (!has_changed || (is_first && section->normal == dvec3(0, 0, 1) && section->at == dvec3(0)))
        continue;
      panes_.turn_section(section->normal);
      panes_.set_focus(section->at);
      clip_.reset();
      if (section->is_clipping) clip_ = Clip{section->at, section->normal};
    } else if (const auto* arm = current->as<fluoroscopy::FluoroscopyState>()) {
      if (arm->is_placed) is_placed_ = true, panes_.set_arm(*arm);
      // A replay that went back has no image of a later moment.
      if (shots_ && !apply && arm->shots < *shots_) panes_.clear_xray();
      if (shots_ && !apply && arm->shots > *shots_) panes_.shoot();
      confirm_live_shots(arm->shots);
      if (arm->shots > *shots_) panes_.shoot();
      shots_ = arm->shots;
      if (arm->shots > 0) {
        char text[80];
        // Show the time instead of the number of images, because live X-rays have no such number.
        std::snprintf(text, sizeof text, "   X-ray %.1f s, %.0f mGy cm\u00b2", arm->seconds,
                      arm->area_product);
        panes_.set_xray_note(text);
      }
    }
  }
  followed_.assign(settings.begin(), settings.end());
}

/// Shows the tool in X-rays, as steel, at its position in the 3-D view.
void PaneController::show_tool_in_xrays(const PaneInput& input) {
  const sim::Value tool = input.tool != nullptr && input.is_tool_at_object ? *input.tool : sim::Value();
  if (!(tool == shadow_instrument_)) {
    shadow_instrument_ = tool;
    shadow_.reset();
    if (const auto solid = tool.is_empty() ? std::nullopt : solid_of(appearance_of(tool)))
      shadow_ = std::make_shared<const haptics::MeshTree>(solid->vertices, solid->triangles);
  }
  if (!shadow_) return panes_.set_xray_tool({});
  const haptics::ServoRecord& r = input.newest;
  const dvec3 at = r.has_contact ? r.proxy_world : r.pose.position_world;
  panes_.set_xray_tool(imaging::Object{
      "instrument", shadow_, {at, haptics::unit_of(r.pose.orientation)}, volume::Matter::steel});
}

bool PaneController::frame(const PaneInput& input) {
  panes_.show(subject_of(input), input.is_changed);
  panes_.set_camera(input.camera, input.clip);
  follow(input.settings);
  const haptics::ServoRecord& r = input.newest;
  constexpr double k_shaft = 60;  // drawn length of the shaft, mm
  const dvec3 shaft = haptics::unit_of(r.pose.orientation) * dvec3(0, 0, 1);
  const dvec3 middle = r.has_contact ? r.proxy_world : r.pose.position_world;
  const dvec3 tip = middle - input.touch_radius * shaft;
  tool_.reset();
  if (input.is_tool_at_object) tool_ = {tip, tip + k_shaft * shaft};
  panes_.show_tool(tip, shaft);
  show_tool_in_xrays(input);
  // After a jump in a replay, the slices show the tool, whatever they showed before the jump.
  constexpr double k_jump_s = 2;
  const double since_last = r.t - std::exchange(shown_t_, r.t);
  const bool has_jumped = !apply && input.is_tool_at_object && (since_last < 0 || since_last > k_jump_s);
  if (follows_tool && (r.has_contact || input.is_inserted || has_jumped))
    panes_.set_focus(r.has_contact ? middle - input.touch_radius * r.normal_world : middle);
  if (panes_.is_live() && !panes_.shows(imaging::PaneKind::xray)) set_live(false);
  if (panes_.is_live()) {
    exposed_ += input.elapsed;
    if (exposed_ >= 1) report_exposure();
  }
  return panes_.frame();
}

void PaneController::rest(std::span<const std::shared_ptr<const sim::Value>> settings) {
  set_live(false);
  for (const auto& setting : settings)
    if (const auto* arm = setting ? setting->as<fluoroscopy::FluoroscopyState>() : nullptr)
      confirm_live_shots(arm->shots);
}

/// Adds reported live exposures that the operation has executed to the known shots. Their images were shown
/// live, so these shots need no image.
void PaneController::confirm_live_shots(std::int64_t shots) {
  // At the first call and in a replay, adopt the number: no further image is due. In a replay, follow() has
  // already taken the image.
  if (!shots_ || !apply || shots < *shots_) shots_ = shots;
  for (; *shots_ < shots && unconfirmed_shots_ > 0; ++*shots_) --unconfirmed_shots_;
}

bool PaneController::is_shot_due(std::span<const std::shared_ptr<const sim::Value>> settings) const {
  if (!apply || !shots_) return false;
  for (const auto& setting : settings)
    if (const auto* arm = setting ? setting->as<fluoroscopy::FluoroscopyState>() : nullptr)
      return arm->shots > *shots_ + unconfirmed_shots_;
  return false;
}

void PaneController::place_arm() {
  if (is_placed_ || !apply) return;
  is_placed_ = true;
  apply(fluoroscopy::CArm(panes_.arm()));
}

void PaneController::set_preset(std::size_t preset) {
  fluoroscopy::CArm arm = panes_.arm();
  fluoroscopy::set_preset(arm, fluoroscopy::k_presets[preset]);
  arm.isocentre = panes_.focus();
  is_placed_ = true;
  panes_.set_arm(arm);
  if (apply) apply(arm);
}

void PaneController::shoot() {
  if (!panes_.is_hounsfield()) return panes_.shoot();  // shows the reason
  place_arm();
  if (apply)
    apply(fluoroscopy::Shoot());  // follow() takes the image after the command is executed
  else
    panes_.shoot();
}

void PaneController::set_live(bool is_live) {
  if (is_live == panes_.is_live()) return;
  if (is_live && !panes_.is_hounsfield()) return panes_.shoot();
  if (is_live) place_arm();
  if (!is_live) report_exposure();
  panes_.set_live(is_live);
}

void PaneController::report_exposure() {
  const double seconds = std::exchange(exposed_, 0);
  if (!apply || seconds <= 0) return;
  fluoroscopy::Shoot shot;
  shot.time = std::max(0.001, k_pulses_per_second * k_pulse_seconds * seconds);
  apply(shot);
  ++unconfirmed_shots_;
}

}  // namespace trephine::view
