// OperationController: the hand that the mouse moves. Its instrument, shaft, tilt, tip moved by keys, guide,
// and held pieces.
#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>
#include <span>
#include <utility>

#include "apps/view/operation_controller.h"
#include "apps/view/tool_appearance.h"
#include "apps/workbench/text.h"
#include "modules/drilling/burr.h"
#include "modules/drilling/craniotome.h"
#include "volume/scan/bone_labels.h"

namespace trephine::view {

using glm::dvec3;
using workbench::Clock;
using workbench::EventLevel;
using workbench::seconds_since;

void OperationController::take_instrument(sim::Value instrument, std::size_t hand) {
  const sim::InstrumentType* type =
      options_.catalogue ? options_.catalogue->find_instrument(instrument.name()) : nullptr;
  // Parameters that do not change the balls with which the tool touches are applied at once.
  const bool is_same = type != nullptr && !is_changing_instrument() && !tool(hand).is_empty() &&
                       tool(hand).name() == instrument.name() && !needs_other_balls(*type, instrument, hand);
  if (type == nullptr || is_same) return apply(std::move(instrument), hand);
  apply(sim::TakeInstrument{std::string(instrument.name()), instrument.words()}, hand);
  requested_tool_ = std::move(instrument);
  requested_hand_ = hand;
  frames_without_job_ = 0;
}

bool OperationController::needs_other_balls(const sim::InstrumentType& type, const sim::Value& instrument,
                                            std::size_t hand) const {
  const sim::ToolNeeds needs = type.needs ? type.needs(instrument.data(), *scene_->base) : sim::ToolNeeds();
  const haptics::ToolShape& needed = needs.tool ? *needs.tool : *scene_->tool;
  return needed != (state_.tools[hand].contact ? *state_.tools[hand].contact : *scene_->tool);
}

/// Ends the wait for an instrument when the hand has it, or when it was refused or discarded.
void OperationController::follow_instrument_change() {
  if (!is_changing_instrument()) return;
  constexpr int k_patience = 120;  // frames without a job
  frames_without_job_ = state_.pending_jobs == 0 ? frames_without_job_ + 1 : 0;
  if (tool(requested_hand_) == requested_tool_ || state_.refused || frames_without_job_ > k_patience)
    requested_tool_ = {};
}

/// Turns the shaft along the normal of the surface, or toward the viewer in ShaftMode::viewer. A round tool
/// is tilted so that its cut is visible. The shaft is at most 63 degrees (1.1 radians) from the direction to
/// the viewer. While the button is pressed, it turns by at most 0.01 radians per frame.
void OperationController::follow_surface(const Ray& ray, bool is_over_bone, bool is_soft) {
  const ToolAppearance tool = appearance_of(state_.tool);
  const bool is_kerrison = tool.foot.kind == FootTool::Kind::kerrison;
  if (!is_over_bone && !is_kerrison) return;
  if (shaft_mode_ == ShaftMode::fixed) return;
  std::optional<dvec3> normal = viewport_.mean_surface_normal(*uncut_, ray);
  // Near an edge, where a Kerrison works, the surface has no definite normal: use the mean of the normal and
  // the direction to the viewer.
  if (is_kerrison) normal = glm::normalize(normal.value_or(-ray.direction) - ray.direction);
  // A gap is entered along the line of sight: the normal of the bone around it does not give that direction.
  if (is_soft) normal = -ray.direction;
  if (!normal) return;
  dvec3 target = shaft_mode_ == ShaftMode::viewer ? -ray.direction
                 : tool.is_ball                   ? Viewport::shaft_direction(*normal, -ray.direction)
                                                  : *normal;
  constexpr double k_flattest = 1.1;  // radians, largest angle from the direction to the viewer
  if (const double slope = std::acos(std::clamp(glm::dot(target, -ray.direction), -1.0, 1.0));
      slope > k_flattest) {
    const dvec3 aside = target - glm::dot(target, ray.direction) * ray.direction;
    target = glm::length(aside) > 1e-6
                 ? std::sin(k_flattest) * glm::normalize(aside) - std::cos(k_flattest) * ray.direction
                 : -ray.direction;
  }
  if (!is_pressed_) {
    shaft_ = target;
    return;
  }
  constexpr double k_max = 0.01;  // radians per frame
  const double angle = std::acos(std::clamp(glm::dot(shaft_, target), -1.0, 1.0));
  if (angle > 1e-6) shaft_ = glm::normalize(shaft_ + std::min(1.0, k_max / angle) * (target - shaft_));
}

/// Returns the index of the body that the hand holds or else touches; -1 if there is no such body.
int OperationController::body_at_hand() const {
  // The overlays of bodies come first, in the order of `bodies`.
  const int count = state_.overlays ? static_cast<int>(state_.bodies.size()) : 0;
  for (int i = 0; i < count; ++i)
    if ((*state_.overlays)[static_cast<std::size_t>(i)].holder == 0) return i;
  const int touched = state_.newest.shape - haptics::item_count(*scene_);  // bodies follow the scene's items
  return state_.newest.has_contact && touched >= 0 && touched < count ? touched : -1;
}

bool OperationController::grasp_or_release() {
  const int body = body_at_hand();
  if (body < 0) return false;
  const auto index = static_cast<std::size_t>(body);
  if ((*state_.overlays)[index].holder == 0) return apply(sim::ReleaseBody()), add_notice("Released."), true;
  apply(sim::HoldBody{state_.bodies[index]});
  add_notice((*state_.overlays)[index].is_detached
                 ? "The piece is grasped. Press T to release it, Shift+T to put it back."
                 : "The body is grasped. Press T to release it.");
  return true;
}

bool OperationController::put_piece_back() {
  const int body = body_at_hand();
  if (body < 0 || !(*state_.overlays)[static_cast<std::size_t>(body)].is_detached) return false;
  if ((*state_.overlays)[static_cast<std::size_t>(body)].holder == 0) apply(sim::ReleaseBody());
  // The surface of a piece is stored in the world coordinates at which it was detached: the identity pose
  // puts it back.
  apply(sim::PlaceBody{state_.bodies[static_cast<std::size_t>(body)], dvec3(0), {1, 0, 0, 0}});
  add_notice("The piece goes back to its place.");
  return true;
}

/// Moves a held piece parallel to the picture, in the orientation of the hand. The piece is also lifted
/// toward the viewer. The lift is the largest distance, parallel to the picture, that the piece has moved
/// from the position of the grasp, at most 20 mm. The piece thus leaves its gap and passes over the
/// surrounding bone. It stops at bone and forbidden structures. Returns false if the hand holds no piece.
bool OperationController::carry_piece(const Ray& ray) {
  const sim::Overlay* held = nullptr;
  if (state_.overlays)
    for (const sim::Overlay& overlay : *state_.overlays)
      if (overlay.holder == 0) held = &overlay;
  if (held == nullptr || !held->surface) {
    carried_.reset();
    return false;
  }
  if (!carried_)
    carried_ = Carried{request_, glm::dot(request_ - ray.origin, ray.direction), 0,
                       haptics::placement_of(state_.newest.pose), PieceGuard(*held->surface, held->grip)};
  const bool is_in_picture = x_ >= 0 && x_ <= 1 && y_ >= 0 && y_ <= 1;
  if (!is_in_picture) return true;  // the piece keeps its pose
  constexpr double k_highest = 20;  // mm
  const dvec3 aside = ray.origin + carried_->along * ray.direction;
  carried_->lift = std::max(carried_->lift, std::min(k_highest, glm::distance(aside, carried_->from)));
  const haptics::Placement target{aside - carried_->lift * ray.direction, turn_along(shaft())};
  const auto is_obstacle = [this, is_bone = bone_in(*version_)](const dvec3& at) {
    return is_bone(at) || std::any_of(live_.engine().forbidden().begin(), live_.engine().forbidden().end(),
                                      [&](const auto& structure) { return structure->contains(at); });
  };
  // Lift the piece first: in its gap it has no room to the side.
  const double up = -glm::dot(target.position_world - carried_->hand.position_world, ray.direction);
  if (up > 0) {
    const haptics::Placement above{carried_->hand.position_world - up * ray.direction, target.rotation};
    carried_->hand = carried_->guard.move(carried_->hand, above, is_obstacle);
  }
  carried_->hand = carried_->guard.move(carried_->hand, target, is_obstacle);
  is_lifted_ = true;
  mouse_.set(carried_->hand.position_world, carried_->hand.rotation, false, std::nullopt);
  return true;
}

/// Returns a test that is true for points (world, mm) in bone of a version; the version must outlive the
/// test. Bone labels count as well, because a window of intensities excludes marrow.
std::function<bool(const dvec3&)> OperationController::bone_in(const volume::Version& version) const {
  return [this, &version, labelled = volume::BoneClassifier(*scene_->base, {}, &version)](const dvec3& at) {
    const dvec3 p = scene_->base->frame.volume_from_world(at);
    return (version.distance(p) > 0 &&
            std::any_of(solids_.begin(), solids_.end(),
                        [&](const volume::Field& f) { return f.value(p) >= 0; })) ||
           labelled.has_bone_label(at);
  };
}

/// Returns the depth of a press at the bone under the cursor, and the outward direction; the tool is pressed
/// in the opposite direction. The outward direction is the direction to the viewer. On a slope, it is tilted
/// toward the normal of the uncut surface, until the tool rests within 0.5 mm of the cursor. On an edge of
/// bone the depth is smaller, because a deep press would pull the tool around the edge.
OperationController::Press OperationController::press_at(const Ray& ray, double hit) const {
  const double depth = press_depth(ray, hit);
  // Sum of the offsets of the uncut bone around the point: it points into the bone.
  constexpr double k_reach = 2.5, k_step = 0.5;  // mm
  const dvec3 at = ray.origin + hit * ray.direction;
  dvec3 bone(0);
  double size = 0;  // length that `bone` has for a half-space
  int all = 0, solid_count = 0;
  for (double z = -k_reach; z <= k_reach; z += k_step)
    for (double y = -k_reach; y <= k_reach; y += k_step)
      for (double x = -k_reach; x <= k_reach; x += k_step) {
        const dvec3 offset(x, y, z);
        if (glm::length(offset) > k_reach) continue;
        ++all;
        size += 0.5 * std::abs(z);
        const dvec3 p = scene_->base->frame.volume_from_world(at + offset);
        if (std::any_of(solids_.begin(), solids_.end(),
                        [&](const volume::Field& solid) { return solid.value(p) >= 0; }))
          bone += offset, ++solid_count;
      }
  // In the middle of uncut bone, as in a drilled hole, the sum is small and gives no normal.
  constexpr double k_least = 0.2;  // share of the length for a half-space
  if (glm::length(bone) < k_least * size) return {-ray.direction, depth};
  const dvec3 normal = -glm::normalize(bone);
  const double slope = glm::dot(normal, -ray.direction);
  // Deep in a hole, the nearest uncut surface may be the one on the far side of the bone.
  if (slope < 0) return {-ray.direction, depth};
  // Bone fills half of a ball around a point of a flat surface, and less of a ball around a point of an edge.
  constexpr double k_edge = 0.4, k_edge_depth = 1.5;  // share of the ball; mm, largest depth on an edge
  const double pressed = solid_count < k_edge * all ? std::min(depth, k_edge_depth) : depth;
  constexpr double k_aside = 0.5;  // mm, largest offset of the resting tool from the cursor
  const double sine = std::min(1.0, k_aside / pressed);
  const dvec3 aside = -ray.direction - slope * normal;
  if (glm::length(aside) <= sine) return {-ray.direction, pressed};
  return {std::sqrt(1 - sine * sine) * normal + sine * glm::normalize(aside), pressed};
}

void OperationController::tilt(double right, double up) {
  constexpr double k_radians = 3.14159265358979 / 180, k_max = 75;  // degrees
  const volume::Camera camera = viewport_.camera();
  const dvec3 toward = right * glm::cross(camera.forward, camera.up) + up * camera.up;
  const dvec3 axis = glm::cross(shaft(), toward);
  const double angle = std::hypot(right, up);
  if (angle <= 0 || glm::length(axis) < 0.05 * angle) return;
  const glm::dquat before = tilt_;
  tilt_ = glm::normalize(glm::angleAxis(k_radians * angle, glm::normalize(axis)) * tilt_);
  if (tilt_angle() > k_max) tilt_ = before;
}

double OperationController::tilt_angle() const {
  return std::acos(std::clamp(glm::dot(shaft(), shaft_), -1.0, 1.0)) * 180 / 3.14159265358979;
}

OperationController::ShaftMode OperationController::select_next_shaft_mode() {
  shaft_mode_ = static_cast<ShaftMode>((static_cast<int>(shaft_mode_) + 1) % 3);
  if (shaft_mode_ == ShaftMode::fixed) shaft_ = shaft();
  tilt_ = {1, 0, 0, 0};
  return shaft_mode_;
}

void OperationController::move_tip(double right, double up) {
  const volume::Camera camera = viewport_.camera();
  const double height =
      camera.height * reach_ / std::max(1.0, camera.distance);  // height of the picture at the tip, mm
  const double width = height * camera.columns / camera.rows;
  x_ = std::clamp(x_ + right / width, 0.0, 1.0);
  y_ = std::clamp(y_ + up / height, 0.0, 1.0);
}

/// Returns the point where the ray meets bone. If the ray passes within 4 mm of other bone that is at least
/// 5 mm nearer to the viewer, or meets no bone itself, returns a point of that bone.
std::optional<dvec3> OperationController::bone_near(const Ray& ray, double hit) {
  constexpr int k_rays = 8;
  constexpr double k_around = 4, k_nearer = 5;  // mm
  const dvec3 axis = std::abs(ray.direction.z) < 0.9 ? dvec3(0, 0, 1) : dvec3(0, 1, 0);
  const dvec3 a = glm::normalize(glm::cross(ray.direction, axis)), b = glm::cross(a, ray.direction);
  std::optional<dvec3> best;
  if (hit >= 0) best = ray.origin + hit * ray.direction;
  double nearest = hit >= 0 ? hit - k_nearer : 1e9;
  for (int i = 0; i < k_rays; ++i) {
    const double angle = 2 * 3.14159265358979 * i / k_rays;
    const dvec3 offset = k_around * (std::cos(angle) * a + std::sin(angle) * b);
    const double distance = viewport_.distance_to_solid(*version_, {ray.origin + offset, ray.direction});
    if (distance >= 0 && distance < nearest)
      nearest = distance, best = ray.origin + offset + distance * ray.direction;
  }
  return best;
}

/// Returns the orientation of a tool with this shaft, rolled about it.
glm::dquat OperationController::turn_along(const dvec3& shaft) const {
  constexpr double k_roll = 3.14159265358979 / 12;
  const dvec3 up(0, 0, 1);
  return glm::dquat(up, shaft) * glm::angleAxis(k_roll * roll_, up);
}

/// True if an event of the newest state has this name.
bool OperationController::has_event(std::string_view name) const {
  return std::any_of(state_.events.begin(), state_.events.end(),
                     [name](const sim::Event& event) { return event.value.name() == name; });
}

/// Holds a tool on the line along which it is inserted; returns false if the cursor determines its pose.
bool OperationController::follow_line(const Ray& ray, const ToolAppearance& tool, bool is_pressed) {
  const bool was_holding = line_.is_holding();
  LineGuide::Input input;
  input.length = tool.insertion, input.is_drill = tool.is_drill;
  input.ray_origin = ray.origin, input.ray_direction = ray.direction;
  if (tool.insertion > 0)
    if (const double old = viewport_.distance_to_solid(*uncut_, ray); old >= 0)
      input.surface = ray.origin + old * ray.direction;
  input.shaft = shaft();
  input.tip = state_.newest.has_contact ? state_.newest.proxy_world : state_.newest.pose.position_world;
  input.is_pressed = is_pressed;
  has_drill_stopped_ = is_pressed && (has_drill_stopped_ || has_event("perforator-stopped"));
  input.has_stopped = has_drill_stopped_;
  input.seconds = seconds_since(std::exchange(guided_at_, Clock::now()));
  const std::optional<LineGuide::Pose> pose = line_.follow(planned_lines_, input);
  viewport_.mark_line(line_.line());
  if (was_holding && !pose) is_lifted_ = true;
  if (!pose) return false;
  is_lifted_ = true;
  mouse_.set(pose->at_world, turn_along(pose->shaft), pose->is_pressed,
             pose->is_jump ? std::optional(pose->at_world) : std::nullopt);
  return true;
}

/// Holds a tool by its guide, with a foot or along a line; returns false if the guide has no pose for it.
bool OperationController::follow_guide(const Ray& ray, double hit) {
  const bool was_holding = guide_.is_holding(), is_pressed = std::exchange(has_click_, false) || is_pressed_;
  const ToolAppearance appearance = appearance_of(state_.tool);
  const FootTool tool = appearance.foot;
  if (tool.kind == FootTool::Kind::none && !was_holding) return follow_line(ray, appearance, is_pressed);
  ToolGuide::Input input;
  input.tool = tool;
  input.ray_origin = ray.origin, input.ray_direction = ray.direction;
  if (hit >= 0) input.surface = ray.origin + hit * ray.direction;
  if (tool.kind == FootTool::Kind::kerrison) input.surface = bone_near(ray, hit);
  if (const double old = viewport_.distance_to_solid(*uncut_, ray); old >= 0)
    input.old_surface = ray.origin + old * ray.direction;
  input.shaft = shaft();
  input.tip = state_.newest.has_contact ? state_.newest.proxy_world : state_.newest.pose.position_world;
  input.is_pressed = is_pressed;
  input.seconds = seconds_since(std::exchange(guided_at_, Clock::now()));
  input.version = version_;
  const std::optional<ToolGuide::Pose> pose = guide_.follow(bone_in(*version_), bone_in(*uncut_), input);
  viewport_.mark_line(guide_.edge());
  if (std::string reason = guide_.take_message(); !reason.empty()) {
    // Dismiss the message of the previous position.
    if (seconds() - guide_refused_at_ < Notices::k_refusal_seconds) notices_.dismiss(guide_refused_at_);
    guide_refused_at_ = seconds();
    notices_.add({seconds(), static_cast<double>(state_.newest.tick) / options_.rate_hz, EventLevel::refusal,
                  "The tool cannot work here: " + reason});
  }
  // Dismiss the message when the foot fits.
  if (!guide_.edge().empty() && seconds() - guide_refused_at_ < Notices::k_refusal_seconds)
    notices_.dismiss(seconds()), guide_refused_at_ = -1e9;
  if (was_holding && !pose) is_lifted_ = true;
  if (!was_holding && pose && tool.kind == FootTool::Kind::kerrison)
    add_notice("The foot goes under the marked edge. Press again to bite.", EventLevel::outcome);
  if (!pose) return false;
  mouse_.set(pose->at_world, pose->turn, pose->is_pressed,
             pose->is_jump ? std::optional(pose->at_world) : std::nullopt);
  return true;
}

/// Returns true while the surface of the bone still contains a piece that was just detached: drawn together,
/// they would flicker. Waits at most 1.5 s, because a running tool changes the surface all the time.
bool OperationController::waits_for_bone() {
  constexpr double k_longest = 1.5;
  const auto count = [](const sim::Overlays& all) {
    return std::count_if(all.begin(), all.end(), [](const sim::Overlay& o) { return o.is_detached; });
  };
  if (!shown_ || viewport_.is_whole() || count(*state_.overlays) <= count(*shown_)) {
    waits_since_ = -1;
    return false;
  }
  if (waits_since_ < 0) waits_since_ = seconds();
  return seconds() - waits_since_ < k_longest;
}

/// Stops the press of a tool that slid behind bone, where the user cannot see it, and shows a message. The
/// press continues when the button is pressed again, or when the cursor moves.
void OperationController::watch_sight(const Ray& ray, bool is_pressed) {
  constexpr double k_seconds = 0.2;  // s
  constexpr double k_moved = 1;      // mm, of the cursor at the distance of the bone
  // Least thickness of bone in front of a hidden tool, mm. Rays meet whole voxels, also those at the rim of a
  // hole that are cut in part.
  const glm::dvec3& spacing = scene().base->frame.spacing();
  const double cover = std::max({1.0, spacing.x, spacing.y, spacing.z});
  if (is_hidden_ && (!is_pressed || reach_ * glm::distance(ray.direction, hidden_ray_) > k_moved))
    is_hidden_ = false, visible_at_ = state_.newest.t;
  const dvec3 sight = state_.newest.proxy_world - ray.origin;
  const double distance = glm::length(sight);
  const double bone = is_pressed && distance > 0
                          ? viewport_.distance_to_solid(*version_, {ray.origin, sight / distance})
                          : -1;
  const bool is_visible = bone < 0 || bone > distance - state_.tool_radius - cover;
  if (is_visible) visible_at_ = state_.newest.t;
  if (is_hidden_ || state_.newest.t - visible_at_ < k_seconds) return;
  is_hidden_ = true, hidden_ray_ = ray.direction;
  show_refusal("The tool slid behind bone, out of sight, and stopped. Move the cursor, or turn the picture.");
}

/// Shows a message if a pressed burr removes hardly any bone: below a certain force it rubs and does not cut.
/// A second message appears only after the burr was released, or has cut clearly: neither a bounce nor a slow
/// cut that is near the limit repeats it.
void OperationController::watch_progress() {
  constexpr double k_seconds = 2, k_least = 0.5, k_clear = 2;  // s; mm³ and mm³ in this time
  const haptics::ServoRecord& newest = state_.newest;
  if (!newest.pose.is_pressed()) is_rub_reported_ = false;
  const auto first_hand = std::span(state_.watches).first(live_.engine().forbidden().size());
  const bool is_in_structure =
      std::any_of(first_hand.begin(), first_hand.end(), [](const auto& watch) { return watch.is_inside; });
  const bool is_working = newest.pose.is_pressed() && newest.has_contact && !is_in_structure &&
                          state_.tool.as<drilling::Burr>() != nullptr;
  const bool has_cut = state_.removed_mm3 >= progress_mm3_ + (is_rub_reported_ ? k_clear : k_least);
  const bool is_over = newest.t - progress_at_ >= k_seconds;
  if (is_working && !has_cut && !is_over) return;
  if (is_working && has_cut) is_rub_reported_ = false;
  progress_at_ = newest.t, progress_mm3_ = state_.removed_mm3;
  if (!is_working || has_cut || std::exchange(is_rub_reported_, true)) return;
  show_refusal(
      workbench::format_text("The burr rubs and hardly cuts at %.1f N. %s", glm::length(newest.force_world),
                             options_.device ? "Press harder." : "Press deeper: PgDn, or the slider Press.")
          .c_str());
}

/// Shows a message if a craniotome is put away after a cut that detached no piece: a thin bridge of bone is
/// hard to see. Waits for the search for pieces, which runs in the background.
void OperationController::watch_flap() {
  constexpr double k_least = 50, k_wait = 2;  // mm³ of a cut; s
  const bool has_craniotome = state_.tool.as<drilling::Craniotome>() != nullptr;
  if (has_craniotome) {
    if (!flap_cut_ || flap_cut_->ended_at >= 0) flap_cut_ = {state_.removed_mm3, state_.bodies.size(), -1};
    return;
  }
  if (!flap_cut_) return;
  if (flap_cut_->ended_at < 0) flap_cut_->ended_at = seconds();
  if (state_.pending_jobs > 0 || seconds() - flap_cut_->ended_at < k_wait) return;
  const FlapCut cut = *std::exchange(flap_cut_, std::nullopt);
  if (state_.bodies.size() > cut.bodies || state_.removed_mm3 - cut.removed_mm3 < k_least) return;
  show_refusal(
      "No piece is free yet: bone still holds it. Cut again where the kerf is not open, first at the holes.");
}

}  // namespace trephine::view
