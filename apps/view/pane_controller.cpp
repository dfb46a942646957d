#include "apps/view/pane_controller.h"

#include <algorithm>
#include <cstdio>
#include <utility>

#include "modules/cross_section/cross_section.h"
#include "modules/ct_viewer/ct_viewer.h"
#include "modules/fluoroscopy/fluoroscopy.h"

namespace trephine::view {

using glm::dvec3;

namespace {

imaging::Subject subject_of(const PaneNews& news) {
  imaging::Subject subject;
  subject.scan = news.scene.base;
  subject.version = news.version;
  for (const haptics::TouchItem& item : news.scene.items)
    if (!subject.bone && !item.is_mesh() && &item.field.volume() == news.scene.base.get())
      subject.bone = item.field.shape();
  for (const auto& structure : news.forbidden) subject.structures.push_back(structure->shape());
  if (news.overlays != nullptr)
    for (const sim::Overlay& one : *news.overlays)
      if (one.surface && (one.kind == sim::Overlay::Kind::bone || one.kind == sim::Overlay::Kind::metal))
        subject.things.push_back(
            {one.name, one.surface, one.place, one.kind == sim::Overlay::Kind::bone, false});
  if (news.plan != nullptr)
    for (const sim::Overlay& one : *news.plan)
      subject.plan.insert(subject.plan.end(), one.lines.begin(), one.lines.end());
  subject.depths.assign(news.depths.begin(), news.depths.end());
  return subject;
}

}  // namespace

void PaneController::begin() {
  panes_.forget();
  tool_.reset(), followed_.clear(), clip_.reset();
  shots_ = 0, is_placed_ = false, exposed_ = 0, told_ = 0;
}

/// Reads the settings that changed since, from any source.
void PaneController::follow(std::span<const std::shared_ptr<const sim::Value>> settings) {
  const bool is_first = followed_.empty();
  for (std::size_t i = 0; i < settings.size(); ++i) {
    const std::shared_ptr<const sim::Value>& now = settings[i];
    const auto before = i < followed_.size() ? followed_[i] : nullptr;
    if (!now || now == before) continue;
    if (const auto* looks = now->as<ct_viewer::CtViewerState>()) {
      const auto* looked = before ? before->as<ct_viewer::CtViewerState>() : nullptr;
      if (looks->is_looking && (!looked || !looked->is_looking || looked->at != looks->at))
        panes_.look_at(looks->at);
      if (looks->is_window &&
          (!looked || !looked->is_window || !(static_cast<const ct_viewer::GreyWindow&>(*looked) == *looks)))
        panes_.set_window(*looks);
    } else if (const auto* section = now->as<cross_section::SectionState>()) {
      const auto* was = before ? before->as<cross_section::SectionState>() : nullptr;
      const bool is_other = !was || was->at != section->at || was->normal != section->normal ||
                            was->is_clipping != section->is_clipping;
      // At its beginning the settings are empty.
      if (!is_other || (is_first && section->normal == dvec3(0, 0, 1) && section->at == dvec3(0))) continue;
      panes_.turn_section(section->normal);
      panes_.look_at(section->at);
      clip_.reset();
      if (section->is_clipping) clip_ = Clip{section->at, section->normal};
    } else if (const auto* arm = now->as<fluoroscopy::FluoroscopyState>()) {
      if (arm->is_placed) is_placed_ = true, panes_.set_arm(*arm);
      // A live second has its pictures already. A shot of an operation that is gone back is not taken
      // again.
      for (; shots_ < arm->shots && told_ > 0; ++shots_) --told_;
      if (arm->shots > shots_ && !is_first) panes_.shoot();
      shots_ = arm->shots;
      if (arm->shots > 0) {
        char text[80];
        std::snprintf(text, sizeof text, "   %d shots, %.0f mGy cm\u00b2", static_cast<int>(arm->shots),
                      arm->area_product);
        panes_.set_xray_note(text);
      }
    }
  }
  followed_.assign(settings.begin(), settings.end());
}

bool PaneController::frame(const PaneNews& news) {
  panes_.show(subject_of(news), news.is_changed);
  panes_.set_eye(news.eye, news.clip);
  follow(news.settings);
  const haptics::ServoRecord& r = news.newest;
  const dvec3 tip = r.has_contact ? r.proxy_world : r.pose.position_world;
  constexpr double k_shaft = 60;  // mm of it that are drawn
  const dvec3 shaft = haptics::unit_of(r.pose.orientation) * dvec3(0, 0, 1);
  tool_.reset();
  if (news.is_tool_there) tool_ = {tip, tip + k_shaft * shaft};
  panes_.show_tool(tip, shaft);
  if (follows_tool && r.has_contact) panes_.look_at(tip);
  if (panes_.is_live() && !panes_.sees(imaging::PaneKind::xray)) set_live(false);
  if (panes_.is_live()) {
    exposed_ += news.elapsed;
    if (exposed_ >= 1) tell_exposure();
  }
  return panes_.frame();
}

void PaneController::rest(std::span<const std::shared_ptr<const sim::Value>> settings) {
  set_live(false);
  for (const auto& one : settings)
    if (const auto* arm = one ? one->as<fluoroscopy::FluoroscopyState>() : nullptr)
      shots_ = arm->shots, told_ = 0;
}

void PaneController::place_arm() {
  if (is_placed_ || !tell) return;
  is_placed_ = true;
  tell(fluoroscopy::CArm(panes_.arm()));
}

void PaneController::set_preset(std::size_t preset) {
  fluoroscopy::CArm arm = panes_.arm();
  fluoroscopy::set_preset(arm, fluoroscopy::k_presets[preset]);
  arm.isocentre = panes_.looked_at();
  is_placed_ = true;
  panes_.set_arm(arm);
  if (tell) tell(arm);
}

void PaneController::shoot() {
  if (!panes_.is_hounsfield()) return panes_.shoot();  // says why not
  place_arm();
  if (tell)
    tell(fluoroscopy::Shoot());  // the image is taken when it is done
  else
    panes_.shoot();
}

void PaneController::set_live(bool is_live) {
  if (is_live == panes_.is_live()) return;
  if (is_live && !panes_.is_hounsfield()) return panes_.shoot();
  if (is_live) place_arm();
  if (!is_live) tell_exposure();
  panes_.set_live(is_live);
}

void PaneController::tell_exposure() {
  const double seconds = std::exchange(exposed_, 0);
  if (!tell || seconds <= 0) return;
  fluoroscopy::Shoot shot;
  shot.time = std::max(0.001, k_pulses * k_pulse * seconds);
  tell(shot);
  ++told_;
}

}  // namespace trephine::view
