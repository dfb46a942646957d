#include "apps/view/operation_controller.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdio>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>

#include "apps/view/device_axes.h"
#include "apps/view/tool_appearance.h"
#include "apps/workbench/text.h"
#include "volume/base/percentile.h"

namespace trephine::view {

using glm::dvec3;
using workbench::Clock;
using workbench::EventLevel;
using workbench::seconds_since;

namespace {

constexpr std::size_t k_max_times = 1 << 20;  // recorded frame times; enough for hours

haptics::ServoOptions servo_options(const WindowOptions& options) {
  haptics::ServoOptions servo;
  servo.rate_hz = options.rate_hz;
  servo.force = options.force;
  return servo;
}

std::vector<haptics::Device*> devices_of(const WindowOptions& options, haptics::Device& mouse) {
  std::vector<haptics::Device*> devices{options.device ? options.device.get() : &mouse};
  if (options.left_device) devices.push_back(options.left_device.get());
  return devices;
}

}  // namespace

OperationController::OperationController(const haptics::TouchScene& scene, const WindowOptions& options,
                                         vtkRenderWindow* window)
    : scene_(&scene),
      options_(options),
      viewport_(scene, window, true),
      mouse_(viewport_.outside_point()),
      pedal_(options.pedal),
      devices_(devices_of(options, mouse_)),
      live_(devices_, options.start->engine, servo_options(options), options.recorder,
            options.start->first_tick),
      started_(Clock::now()) {
  TREPHINE_ASSERT(live_.engine().tool().scene.get() == &scene);
  TREPHINE_ASSERT(live_.engine().hand_count() == devices_.size());
  state_ = live_.fetch_state();
  version_ = state_.version;
  uncut_ = haptics::uncut_version(scene);
  solids_ = haptics::solids_of(scene);
  guided_at_ = started_;
  if (options.plan)
    for (const volume::PlannedTrajectory& line : options.plan->trajectories)
      planned_lines_.push_back({line.entry_world, line.target_world});
  if (const auto& plan = live_.engine().state().plan; plan && !plan->procedure.is_empty())
    steps_.emplace(plan);
  for (int i = 0; i < haptics::item_count(scene); ++i)
    if (const auto& depth = haptics::item_of(scene, i).depth; depth && depth->is_streamed()) scenery_ = i;
}

OperationController::~OperationController() { finish(); }

Status OperationController::start() {
  viewport_.request_all(version_);
  if (options_.free_pieces > 0) live_.watch_pieces(options_.free_pieces);
  device_start_ = device_start(viewport_, *version_);
  place_devices();
  if (Status error = live_.start()) return error;
  is_started_ = true;
  return pedal_.open();
}

const WindowReport& OperationController::finish() {
  if (is_finished_) return report_;
  is_finished_ = true;
  live_.stop();
  pedal_.close();
  state_ = live_.fetch_state();
  version_ = state_.version;
  report_.servo = live_.servo_report();
  const auto offsets = live_.derived_report(sim::DerivedKind::offset_fields);
  report_.offset_updates = offsets.count;
  report_.longest_offset_update_seconds = offsets.longest_seconds;
  report_.edits = live_.edit_report();
  if (options_.recorder) report_.recording_error = options_.recorder->finish(live_.engine());
  report_.removed_mm3 = state_.removed_mm3;
  report_.strokes = state_.strokes;
  report_.triangles = viewport_.triangle_count();
  report_.frame_p50_ms = percentile_of(frame_ms_, 50), report_.frame_p99_ms = percentile_of(frame_ms_, 99);
  report_.drilling_frames = static_cast<int>(drilling_ms_.size());
  report_.drilling_p50_ms = percentile_of(drilling_ms_, 50),
  report_.drilling_p99_ms = percentile_of(drilling_ms_, 99);
  return report_;
}

void OperationController::set_depth(double mm) { depth_mm_ = std::clamp(mm, 0.5, 12.0); }

void OperationController::go_to_stroke(std::size_t strokes) {
  strokes = std::clamp(strokes, state_.first_stroke, state_.all_strokes);
  std::size_t at = requested_stroke_.value_or(state_.strokes);
  requested_stroke_ = strokes;
  for (; at > strokes; --at) undo();
  for (; at < strokes; ++at) redo();
}

void OperationController::change_history(HistoryStep step) {
  history_steps_.push_back(step);
  send_history_steps();
}

/// Returns true if the mouse's button is down, or the servo has processed its release. Always true for a
/// haptic device, which has its own button.
bool OperationController::is_release_processed() const {
  if (options_.device || is_pressed_) return true;
  return !mouse_.is_pressed() && state_.newest.t >= mouse_.released_at();
}

void OperationController::send_history_steps() {
  if (history_steps_.empty() || !is_release_processed()) return;
  for (const HistoryStep step : history_steps_) step == HistoryStep::undo ? live_.undo() : live_.redo();
  history_steps_.clear();
  notices_.dismiss(seconds());
  if (!job_.empty()) add_notice("The running command was cancelled.", EventLevel::outcome);
  // Undo ends the insertion of a probe or a catheter, whose track it may close.
  line_.withdraw();
}

/// Resets a latched fault of a mouse after half a second. A mouse has no motors, so the user need not confirm
/// the reset.
void OperationController::restore_force() {
  if (has_haptic_device()) return;
  constexpr double k_wait_seconds = 0.5;
  if (latched_faults() == 0)
    fault_since_.reset();
  else if (!fault_since_)
    fault_since_ = Clock::now();
  else if (seconds_since(*fault_since_) > k_wait_seconds) {
    live_.reset_faults();
    fault_since_ = Clock::now();
  }
}

/// Maps the axes of haptic devices to those of the picture. The left hand starts to the left of the right
/// one.
void OperationController::place_devices() {
  constexpr double k_apart = 40;  // mm
  const haptics::DeviceView view{device_start_, screen_axes(viewport_)};
  if (options_.device) options_.device->set_view(view);
  if (!options_.left_device) return;
  haptics::DeviceView left = view;
  left.start_world -= k_apart * (left.world_from_device * dvec3(1, 0, 0));
  options_.left_device->set_view(left);
}

bool OperationController::show_workspaces(bool are_shown) {
  if (!are_shown && shows_workspaces_) shown_.reset();
  shows_workspaces_ = are_shown;
  return std::any_of(devices_.begin(), devices_.end(),
                     [](const haptics::Device* device) { return device->workspace().has_value(); });
}

/// Adds the clip volumes of depth images and the workspaces of the devices, if they are to be shown.
sim::Overlays OperationController::with_guides(sim::Overlays overlays) const {
  if (shows_clip_volumes_) overlays = with_clip_volumes(std::move(overlays), state_.depths);
  if (shows_workspaces_)
    for (const haptics::Device* device : devices_)
      if (const auto workspace = device->workspace()) overlays.push_back(workspace_overlay(*workspace));
  return overlays;
}

void OperationController::frame() {
  place_devices();
  if (const std::optional<bool> change = pedal_.change(seconds())) press(*change);
  if (pedal_.take_loss())
    add_notice("The pedal does not respond. Connect it again, close this window, and continue the operation.",
               EventLevel::danger);
  if (!options_.device) follow_cursor();

  // Fetch the state of the other threads: the version, its changed voxels, the newest tick.
  state_ = live_.fetch_state();
  if (state_.refused) refused_ = refusal_text(*state_.refused);
  if (state_.refused) release_handle();
  collect_notices();
  send_history_steps();
  watch_progress();
  watch_flap();
  if (steps_) steps_->follow(live_, state_, seconds());
  if (steps_ && prepared_step_ != steps_->index() && viewport_.is_complete()) {
    prepared_step_ = steps_->index();
    live_.prepare_instruments(steps_->instruments_ahead());
  }
  restore_force();
  follow_instrument_change();
  if (state_.job != job_) job_ = state_.job, job_started_ = seconds();
  drag_handle();
  if (state_.refused || requested_stroke_ == state_.strokes) requested_stroke_.reset();
  version_ = state_.version;
  viewport_.request(version_, state_.changed);
  for (std::size_t h = 0; h < state_.tools.size(); ++h) {
    const auto& [parameters, contact] = state_.tools[h];
    if (contact) viewport_.set_contact_tool(*contact, h);
    if (options_.device || was_in_picture_ || is_tip_held_ || is_pressed_)
      viewport_.show_stylus(state_.hands[h], appearance_of(parameters), *version_,
                            -viewport_.ray_at(x_, y_).direction);
  }
  const bool is_held =
      state_.overlays && std::any_of(state_.overlays->begin(), state_.overlays->end(),
                                     [](const sim::Overlay& overlay) { return overlay.holder >= 0; });
  if (state_.overlays && (is_held || !waits_for_bone()) &&
      (is_held || shown_ != state_.overlays || shows_clip_volumes_ || shows_workspaces_)) {
    shown_ = state_.overlays;
    if (shows_clip_volumes_ || shows_workspaces_)
      viewport_.show(with_guides(*shown_), state_.hands);
    else
      viewport_.show(*shown_, state_.hands);
  }
  touch_scenery();
  const std::optional<double> ms = viewport_.draw();
  ++report_.frames;
  if (!ms) {
    ++report_.frames_skipped;
    return;
  }
  if (frame_ms_.size() < k_max_times) frame_ms_.push_back(static_cast<float>(*ms));
  const bool is_cutting = state_.changed.low.x <= state_.changed.high.x && state_.newest.pose.is_pressed();
  if (is_cutting && drilling_ms_.size() < k_max_times) drilling_ms_.push_back(static_cast<float>(*ms));
}

/// Submits the screen depth of the scenery, by which the hand touches it. The depth around the hand is
/// requested after the view or the scenery changed, or when the hand leaves the part that was read. A picture
/// in which an object hides the hand is not submitted.
void OperationController::touch_scenery() {
  if (scenery_ < 0) return;
  const haptics::ServoRecord& r = state_.newest;
  const dvec3 hip = r.pose.position_world, proxy = r.has_contact ? r.proxy_world : hip;
  if (const std::optional<ScreenDepth::Reading> depth = viewport_.take_depth()) {
    const haptics::depth::DepthPicture& picture = depth->picture;
    const double pixel = glm::length(depth->at - picture.placement.position_world) / picture.camera.fx;
    const std::optional<double> behind = picture.behind(proxy);
    const bool is_hidden =
        state_.newest.shape == scenery_ && r.has_contact && (!behind || *behind > 1 + 2 * pixel);
    hidden_pictures_ += is_hidden;
    constexpr double k_min = 2;  // mm
    if (!is_hidden && depth->edge > k_min) live_.submit_picture(picture, scenery_, depth->at, depth->edge);
    // A hand that was in the scenery before the picture arrived is moved in front of the scenery.
    const double deepest = depth_mm_ + 2 * state_.tool_radius + 4;
    if (!is_hidden && !r.has_contact && behind && *behind > -state_.tool_radius && *behind < deepest) {
      const dvec3 ahead = glm::normalize(proxy - picture.placement.position_world);
      landing_ = proxy - (*behind + state_.tool_radius + 1) * ahead;
    }
  }
  constexpr double k_edge = 40, k_margin = 8;  // mm: edge of a request; margin of known depth
  const volume::Camera camera = viewport_.camera();
  const haptics::depth::DepthSet* known = nullptr;
  for (const sim::DisplayedDepths& depths : state_.depths)
    if (depths.item == scenery_) known = depths.set.get();
  if (landing_ && known != nullptr && known->serial != known_depth_serial_) {
    if (!r.has_contact) live_.teleport_tool(version_->base().frame.volume_from_world(*landing_));
    landing_.reset();
  }
  if (known != nullptr) known_depth_serial_ = known->serial;
  const haptics::MeshTree* mesh = nullptr;
  if (state_.overlays)
    for (const sim::Overlay& overlay : *state_.overlays)
      if (overlay.kind == sim::Overlay::Kind::scenery) mesh = overlay.surface.get();
  const bool is_same_view =
      camera.at == requested_camera_.at && camera.forward == requested_camera_.forward &&
      camera.up == requested_camera_.up && camera.columns == requested_camera_.columns &&
      camera.rows == requested_camera_.rows && mesh == requested_mesh_;
  const auto is_known_around = [&](const dvec3& p) {
    return known != nullptr && known->is_known_around(p, k_margin + state_.tool_radius);
  };
  const auto is_near = [&](const dvec3& p) {
    return glm::length(p - glm::clamp(p, mesh->low(), mesh->high())) < k_edge;
  };
  if (mesh == nullptr || (!is_near(hip) && !is_near(proxy))) return;
  // Send no request if the depth around this position was already requested, or is known around the hand.
  const bool is_same_place = glm::length(proxy - requested_at_) < 1;
  if (is_same_view && (is_same_place || (is_known_around(hip) && is_known_around(proxy)))) return;
  requested_camera_ = camera, requested_mesh_ = mesh, requested_at_ = proxy;
  viewport_.request_depth(proxy, k_edge);
}

/// Distance (mm) along the ray to the nearest surface of an overlay that no hand holds, such as a detached
/// body or a model; negative if the ray meets no such surface.
double OperationController::distance_to_bodies(const Ray& ray) const {
  constexpr double k_far = 5000;
  double nearest = -1;
  if (!state_.overlays) return nearest;
  for (const sim::Overlay& overlay : *state_.overlays) {
    if (!overlay.surface || overlay.holder >= 0 || overlay.kind == sim::Overlay::Kind::injury) continue;
    haptics::FacetHit hit;
    int visited = 0;
    if (overlay.surface->cast(overlay.placement.local_from_world(ray.origin),
                              overlay.placement.local_from_world(ray.origin + k_far * ray.direction), true,
                              false, hit, visited) &&
        (nearest < 0 || k_far * hit.t < nearest))
      nearest = k_far * hit.t;
  }
  return nearest;
}

bool OperationController::grasp_handle() {
  const std::optional<dvec3> at = surface_point();
  if (!at || !state_.overlays) return false;
  double nearest = std::max(4.0, 0.015 * reach_);  // mm; larger if the camera is far away
  for (const sim::Overlay& overlay : *state_.overlays)
    for (const sim::Overlay::Handle& handle : overlay.handles)
      if (const double distance = glm::length(handle.at - *at); distance < nearest)
        nearest = distance, dragged_handle_ = handle.move, dragged_to_ = handle.at;
  return has_handle();
}

/// Sends the command that moves the grasped handle to the surface point, at most in every third frame:
/// between two commands, the outline that depends on the handle is drawn.
void OperationController::drag_handle() {
  constexpr int k_every = 3;
  const std::optional<dvec3> at = surface_point();
  if (!has_handle() || !at || ++frames_since_drag_ < k_every || glm::length(*at - dragged_to_) < 0.2) return;
  for (const sim::Field& field : dragged_handle_.schema().fields) {
    const sim::FieldPointer pointer = field.pointer_in(dragged_handle_.data());
    if (auto* const* point = std::get_if<dvec3*>(&pointer); point && field.name == "at") **point = *at;
  }
  apply(dragged_handle_);
  dragged_to_ = *at;
  frames_since_drag_ = 0;
}

std::optional<dvec3> OperationController::surface_point() const {
  if (!options_.device && is_over_bone_ && !is_guided()) return under_cursor_;
  const haptics::ServoRecord& newest = state_.newest;
  const bool is_ball = state_.tools[0].contact && !state_.tools[0].contact->is_six_dof();
  if (newest.has_contact)
    return newest.proxy_world - (is_ball ? state_.tool_radius : 0) * dvec3(newest.normal_world);
  return std::nullopt;
}

std::optional<dvec3> OperationController::picked_point() {
  if (options_.device) return surface_point();
  const Ray ray = viewport_.ray_at(x_, y_);
  double hit = viewport_.distance_to_solid(*version_, ray);
  if (const std::optional<double> face = viewport_.distance_to_clip_face(*version_, ray)) hit = *face;
  if (const double body = distance_to_bodies(ray); body >= 0 && (hit < 0 || body < hit)) hit = body;
  return hit >= 0 ? std::optional(ray.origin + hit * ray.direction) : std::nullopt;
}

/// Returns the depth of a press into the bone under the cursor, at `hit` mm along the ray. The depth is small
/// after the tool slid out of sight, and while it is deeper than that bone: it slipped past an edge, and a
/// deep press would pull it to the other side.
double OperationController::press_depth(const Ray& ray, double hit) const {
  constexpr double k_slip = 1.5, k_slipped_depth = 0.3;  // mm
  const haptics::ServoRecord& newest = state_.newest;
  const double tool = glm::dot(newest.proxy_world - ray.origin, ray.direction);
  const bool has_slipped =
      newest.pose.is_pressed() && (is_hidden_ || (newest.has_contact && tool > hit + k_slip));
  return has_slipped ? std::min(k_slipped_depth, depth_mm_) : depth_mm_;
}

void OperationController::follow_cursor() {
  // The requested position is on the surface under the cursor, and below the surface while the button is
  // down.
  const Ray ray = viewport_.ray_at(x_, y_);
  // A tool with a foot works only while its guide holds it: without a position for the foot, a press must not
  // move the tool.
  const bool is_pressed =
      is_pressed_ && (appearance_of(state_.tool).foot.kind == FootTool::Kind::none || guide_.is_holding());
  if (carry_piece(ray)) return;
  const Viewport::RestingPosition rest = viewport_.resting_position(*version_, ray);
  double hit = is_pressed ? viewport_.distance_to_solid(*version_, ray) : rest.distance;
  bool is_soft = !is_pressed && rest.is_soft;
  if (const double body = distance_to_bodies(ray); body >= 0 && (hit < 0 || body < hit))
    hit = body, is_soft = false;
  if (wait_outside_clip(ray, hit)) return;
  const double guided_hit = hit;
  // In a gap between bones, the tool rests on the structure in front of the bone, and is pressed onto it.
  if (!is_soft)
    if (const std::optional<double> soft = distance_to_forbidden(ray, hit))
      hit = *soft + state_.tool_radius, is_soft = !is_pressed;
  // A working tool that broke through stops. It must not go to the bone on the far side, which is visible
  // through its hole.
  constexpr double k_through = 10;  // mm
  if (is_pressed && is_over_bone_ && hit > reach_ + k_through) hit = reach_;
  if (hit >= 0) reach_ = hit;
  is_over_bone_ = hit >= 0;
  const dvec3 previous = std::exchange(under_cursor_, ray.origin + reach_ * ray.direction);
  const double radius = state_.tool_radius;  // height of a round tool's centre above the surface
  // A larger tool would begin inside the rim of the hole in which the previous tool was.
  if (std::exchange(lifted_radius_, radius) != radius) is_lifted_ = true;
  // A ball on a slope touches before its centre is one radius from the bone under the cursor. The distance to
  // the contact is computed by rays that end at voxels, so that it may be a voxel too short.
  const volume::Frame& frame = scene_->base->frame;
  const double voxel = std::max({frame.spacing().x, frame.spacing().y, frame.spacing().z});
  const auto contact = [&] { return viewport_.distance_to_contact(*version_, ray, radius, hit); };
  constexpr double k_rest = 0.3;  // mm by which an idle tool is requested below the surface
  double along = hit < 0      ? std::max(0.0, reach_ - radius - 8)
                 : is_pressed ? hit - radius + depth_mm_
                              : std::min(hit - radius, contact() + 0.7 * voxel) + k_rest;
  // A craniotome is perpendicular to the bone around it, not to the bone under a cursor that is ahead.
  const bool is_craniotome_held =
      guide_.is_holding() && appearance_of(state_.tool).foot.kind == FootTool::Kind::craniotome;
  follow_surface(
      is_craniotome_held ? Ray{ray.origin, glm::normalize(state_.newest.proxy_world - ray.origin)} : ray,
      is_over_bone_ || is_craniotome_held, is_soft);
  if (follow_guide(ray, guided_hit)) return;
  if (is_soft) along = distance_above_soft(ray, hit - radius);
  // On the edge of bone an idle tool may reach a structure next to it.
  constexpr double k_least_clearance = 0.1;  // mm
  if (!is_soft && !is_pressed && hit >= 0 &&
      clearance_at(ray.origin + along * ray.direction, 0) < k_least_clearance)
    along = distance_above_soft(ray, along);
  // If there is no bone under the cursor, or a structure in front of the bone may be clipped, an idle tool
  // stays in front of structures.
  if (!is_pressed && (hit < 0 || viewport_.clip_plane()) &&
      clearance_at(ray.origin + along * ray.direction, 0) < 0)
    if (const std::optional<double> soft = distance_to_forbidden(ray, hit, Viewport::Clipping::ignored))
      along = std::min(along, *soft);
  dvec3 request = ray.origin + along * ray.direction, press(0);
  if (is_pressed && hit >= 0 && !is_soft) {
    const Press at_cursor = press_at(ray, hit);
    press = -at_cursor.depth * at_cursor.normal;
    request = under_cursor_ + radius * at_cursor.normal + press;
  }
  // If the cursor jumps, or a forbidden structure is in between, lift the stylus over instead of dragging it
  // along a straight line.
  constexpr double k_jump_mm = 8;
  std::optional<dvec3> jump;
  if (is_lifted_ || glm::length(under_cursor_ - previous) > k_jump_mm ||
      (!is_pressed && passes_forbidden(request_, request))) {
    double above = hit >= 0 ? std::max(0.0, std::min(along, contact() - 1.5 * frame.diagonal_mm())) : along;
    // Between a structure and the bone behind it there may be less room: move the lifted position toward the
    // requested one until it is outside the structure.
    constexpr double k_step = 0.25;  // mm
    while (!is_pressed && above < along && clearance_at(ray.origin + above * ray.direction, 0) < 0)
      above = std::min(along, above + k_step);
    jump = ray.origin + above * ray.direction;
  }
  mouse_.set(request, turn_along(shaft()), is_pressed && hit >= 0, jump, press);
  request_ = request, is_lifted_ = false;
  watch_sight(ray, is_pressed);
}

}  // namespace trephine::view
