#include "apps/view/operation_controller.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>

#include "apps/view/tool_look.h"
#include "volume/percentile.h"

namespace trephine::view {

using glm::dvec3;
using workbench::Clock;
using workbench::EventLevel;
using workbench::seconds_since;

namespace {

constexpr std::size_t k_most_times = 1 << 20;  // frames whose time is kept: hours

haptics::ServoOptions servo_options(const WindowOptions& options) {
  haptics::ServoOptions servo;
  servo.rate_hz = options.rate_hz;
  servo.force = options.force;
  return servo;
}

}  // namespace

OperationController::OperationController(const haptics::TouchScene& scene, const WindowOptions& options,
                                         vtkRenderWindow* window)
    : scene_(&scene),
      options_(options),
      viewport_(scene, window, true),
      mouse_(viewport_.outside_point()),
      devices_{options.device ? options.device.get() : &mouse_},
      live_(devices_, options.start->engine, servo_options(options), options.recorder,
            options.start->first_tick),
      started_(Clock::now()) {
  TREPHINE_ASSERT(live_.engine().tool().scene.get() == &scene);
  state_ = live_.fetch_state();
  version_ = state_.version;
  untouched_ = haptics::untouched(scene);
  solids_ = haptics::solids_of(scene);
  guided_at_ = started_;
  for (int i = 0; i < haptics::item_count(scene); ++i)
    if (const auto& depth = haptics::item_of(scene, i).depth; depth && depth->comes_in()) scenery_ = i;
}

OperationController::~OperationController() { finish(); }

volume::Status OperationController::start() {
  viewport_.request_all(version_);
  if (options_.free_pieces > 0) live_.watch_pieces(options_.free_pieces);
  if (volume::Status error = live_.start()) return error;
  is_started_ = true;
  return std::nullopt;
}

const WindowReport& OperationController::finish() {
  if (is_finished_) return report_;
  is_finished_ = true;
  live_.stop();
  state_ = live_.fetch_state();
  version_ = state_.version;
  report_.servo = live_.servo_report();
  const sim::LiveSession::OffsetReport offsets = live_.offset_report();
  report_.offset_updates = offsets.count;
  report_.longest_offset_update_seconds = offsets.longest_seconds;
  report_.edits = live_.edit_report();
  if (options_.recorder) report_.recording = options_.recorder->finish(live_.engine());
  report_.removed_mm3 = state_.removed_mm3;
  report_.strokes = state_.strokes;
  report_.triangles = viewport_.triangle_count();
  report_.frame_p50_ms = volume::percentile_of(frame_ms_, 50),
  report_.frame_p99_ms = volume::percentile_of(frame_ms_, 99);
  report_.drilling_frames = static_cast<int>(drilling_ms_.size());
  report_.drilling_p50_ms = volume::percentile_of(drilling_ms_, 50),
  report_.drilling_p99_ms = volume::percentile_of(drilling_ms_, 99);
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

std::string OperationController::fault_text() const {
  const std::uint32_t faults = state_.newest.faults & haptics::k_latched_faults;
  if (faults == 0) {
    // The deepest structure is named: the one that was entered last, and of those the innermost.
    const sim::ForbiddenWatch* deepest = nullptr;
    for (const sim::ForbiddenWatch& watch : state_.watches)
      if (watch.is_inside && (deepest == nullptr || watch.entered_tick > deepest->entered_tick ||
                              (watch.entered_tick == deepest->entered_tick && watch.depth < deepest->depth)))
        deepest = &watch;
    if (deepest == nullptr) return {};
    char depth[32];
    std::snprintf(depth, sizeof depth, ", %.1f mm deep", deepest->depth);
    const auto at = static_cast<std::size_t>(deepest - state_.watches.data());
    return "The tool is in " + live_.engine().forbidden()[at]->name() + depth + ". Lift it.";
  }
  std::string why;
  if (faults & haptics::fault_lost_device) why = "the device does not answer";
  if (faults & haptics::fault_not_finite) why = "the device sent no number";
  if (faults & haptics::fault_full_ring) why = "the edits stood still";
  if (faults & haptics::fault_stale_scene) why = "the computer was busy elsewhere";
  return "The force is off: " + why +
         (options_.device ? ". Press F to turn it on again." : ". It comes back by itself.");
}

std::string OperationController::notice_text() const {
  const bool is_off = (state_.newest.faults & haptics::k_latched_faults) != 0;
  const std::string fault = is_off ? fault_text() : "", shown = notices_.shown(seconds());
  return fault + (fault.empty() || shown.empty() ? "" : "\n") + shown;
}

EventLevel OperationController::notice_level() const {
  const bool is_off = (state_.newest.faults & haptics::k_latched_faults) != 0;
  return is_off ? EventLevel::danger : notices_.shown_level(seconds());
}

void OperationController::collect_notices() {
  const double now = seconds();
  const auto session_time = [&](std::uint64_t tick) { return static_cast<double>(tick) / options_.rate_hz; };
  for (const sim::Event& event : state_.events) {
    workbench::EventText text = workbench::describe_event(event);
    notices_.add({now, session_time(event.tick), text.level, std::move(text.text)});
    if (const auto* fault = event.what.as<sim::FaultEvent>()) report_.force_faults += !fault->is_cleared;
  }
  if (state_.refused)
    notices_.add({now, session_time(state_.newest.tick), EventLevel::refusal,
                  "Not done: " + state_.refused->message()});
}

/// A mouse has no motors: after a fault its force comes back by itself, once the cause had time to pass.
void OperationController::restore_force() {
  if (options_.device) return;
  constexpr double k_wait_seconds = 0.5;
  if ((state_.newest.faults & haptics::k_latched_faults) == 0)
    fault_since_.reset();
  else if (!fault_since_)
    fault_since_ = Clock::now();
  else if (seconds_since(*fault_since_) > k_wait_seconds) {
    live_.reset_faults();
    fault_since_ = Clock::now();
  }
}

void OperationController::frame() {
  if (!options_.device) follow_cursor();

  // News from the other threads: the version, its changed chunks, the newest tick.
  state_ = live_.fetch_state();
  if (state_.refused) refused_ = state_.refused->message();
  if (state_.refused) drop_point();
  collect_notices();
  restore_force();
  go_on_taking();
  viewport_.set_touch_radius(state_.tool_radius);
  drag_point();
  if (state_.refused || requested_stroke_ == state_.strokes) requested_stroke_.reset();
  version_ = state_.version;
  viewport_.request(version_, state_.changed);
  viewport_.show_stylus(state_.newest, look_of(state_.tool), *version_, -viewport_.ray_at(x_, y_).direction);
  const bool is_held =
      state_.overlays && std::any_of(state_.overlays->begin(), state_.overlays->end(),
                                     [](const sim::Overlay& one) { return one.holder >= 0; });
  if (state_.overlays && (is_held || shown_ != state_.overlays || shows_clip_volumes_)) {
    shown_ = state_.overlays;
    if (shows_clip_volumes_)
      viewport_.show(with_clip_volumes(*shown_, state_.depths), state_.hands);
    else
      viewport_.show(*shown_, state_.hands);
  }
  feel_scenery();
  const std::optional<double> ms = viewport_.draw();
  ++report_.frames;
  if (!ms) {
    ++report_.frames_skipped;
    return;
  }
  if (frame_ms_.size() < k_most_times) frame_ms_.push_back(static_cast<float>(*ms));
  const bool is_cutting = state_.changed.low.x <= state_.changed.high.x && state_.newest.pose.is_pressed();
  if (is_cutting && drilling_ms_.size() < k_most_times) drilling_ms_.push_back(static_cast<float>(*ms));
}

/// Scenery next to the bone is touched as the screen has it: its depth is read around the hand when the
/// view turned, or the hand comes to where nothing was read. A picture in which something hides the hand says
/// nothing of what it touches: its contact stays as before.
void OperationController::feel_scenery() {
  if (scenery_ < 0) return;
  const haptics::ServoRecord& r = state_.newest;
  const dvec3 hip = r.pose.position_world, proxy = r.has_contact ? r.proxy_world : hip;
  if (const std::optional<ScreenDepth::Seen> seen = viewport_.take_depth()) {
    const haptics::depth::DepthPicture& picture = seen->picture;
    const double pixel = glm::length(seen->at - picture.place.position_world) / picture.camera.fx;
    const std::optional<double> behind = picture.behind(proxy);
    const bool hides =
        state_.newest.shape == scenery_ && r.has_contact && (!behind || *behind > 1 + 2 * pixel);
    hidden_ += hides;
    constexpr double k_least = 2;  // mm
    if (!hides && seen->edge > k_least) live_.see(picture, scenery_, seen->at, seen->edge);
    // A hand that was there before the picture is set down before what it shows.
    const double deepest = depth_mm_ + 2 * state_.tool_radius + 4;
    if (!hides && !r.has_contact && behind && *behind > -state_.tool_radius && *behind < deepest) {
      const dvec3 ahead = glm::normalize(proxy - picture.place.position_world);
      landing_ = proxy - (*behind + state_.tool_radius + 1) * ahead;
    }
  }
  constexpr double k_edge = 40, k_left = 8;  // mm: of what is asked for, and that is left when more is
  const volume::Eye eye = viewport_.eye();
  const haptics::depth::DepthSet* known = nullptr;
  for (const sim::SeenDepths& one : state_.depths)
    if (one.item == scenery_) known = one.set.get();
  if (landing_ && known != nullptr && known->serial != felt_picture_) {
    if (!r.has_contact) live_.set_down(version_->base().frame.volume_from_world(*landing_));
    landing_.reset();
  }
  if (known != nullptr) felt_picture_ = known->serial;
  const haptics::MeshTree* drawn = nullptr;
  if (state_.overlays)
    for (const sim::Overlay& one : *state_.overlays)
      if (one.kind == sim::Overlay::Kind::scenery) drawn = one.surface.get();
  const bool is_same_view = eye.at == drawn_from_.at && eye.forward == drawn_from_.forward &&
                            eye.up == drawn_from_.up && eye.columns == drawn_from_.columns &&
                            eye.rows == drawn_from_.rows && drawn == drawn_;
  const auto knows = [&](const dvec3& p) {
    return known != nullptr && known->knows(p, k_left + state_.tool_radius);
  };
  const auto is_near = [&](const dvec3& p) {
    return glm::length(p - glm::clamp(p, drawn->low(), drawn->high())) < k_edge;
  };
  if (drawn == nullptr || (!is_near(hip) && !is_near(proxy))) return;
  // The requested depth is on its way, or the screen shows no more there.
  const bool is_same_place = glm::length(proxy - asked_at_) < 1;
  if (is_same_view && (is_same_place || (knows(hip) && knows(proxy)))) return;
  drawn_from_ = eye, drawn_ = drawn, asked_at_ = proxy;
  viewport_.ask_depth(proxy, k_edge);
}

bool OperationController::take_or_put_down() {
  if (state_.overlays)
    for (const sim::Overlay& one : *state_.overlays)
      if (one.holder == 0) return apply(sim::ReleaseBody()), true;
  const int body = state_.newest.shape - haptics::item_count(*scene_);  // they come after what the scene has
  if (!state_.newest.has_contact || body < 0 || body >= static_cast<int>(state_.bodies.size())) return false;
  apply(sim::HoldBody{state_.bodies[static_cast<std::size_t>(body)]});
  return true;
}

void OperationController::take(sim::Value what) {
  const bool was_taking = is_taking();
  taken_ = {};
  const sim::InstrumentType* type =
      options_.catalogue ? options_.catalogue->find_instrument(what.name()) : nullptr;
  const sim::ToolNeeds needs =
      type && type->needs ? type->needs(what.data(), *scene_->base) : sim::ToolNeeds();
  // A tool without needs touches as the operation began, but not with the balls of another tool.
  const bool is_own = needs.touch_radius == 0 && needs.balls.empty() && scene_->tool_balls.empty();
  wanted_radius_ = is_own ? scene_->tool_radius : needs.touch_radius;
  const std::vector<dvec3>& balls = is_own ? scene_->tool_balls : needs.balls;
  wanted_balls_ = balls.size();
  const bool is_ready = type == nullptr || (wanted_balls_ == state_.tool_balls &&
                                            std::abs(wanted_radius_ - state_.tool_radius) < 0.05);
  if (is_ready && !was_taking) return apply(std::move(what));  // else the others are on their way
  if (!was_taking) before_ = state_.tool;
  frames_without_job_ = 0;
  apply(sim::LayDown());
  apply(sim::ToolGeometry{wanted_radius_, balls});
  taken_ = std::move(what);
}

void OperationController::go_on_taking() {
  if (!is_taking()) return;
  const bool has_come =
      wanted_balls_ == state_.tool_balls && std::abs(wanted_radius_ - state_.tool_radius) < 1e-9;
  constexpr int k_patience = 120;  // frames without a job
  frames_without_job_ = state_.pending_jobs == 0 ? frames_without_job_ + 1 : 0;
  if (has_come && !state_.refused) {
    apply(std::exchange(taken_, {}));
  } else if (state_.refused || frames_without_job_ > k_patience) {
    taken_ = {};
    if (!before_.is_empty()) apply(std::exchange(before_, {}));
  }
}

/// mm along the ray to what came off; negative: to none.
double OperationController::distance_to_bodies(const Ray& ray) const {
  constexpr double k_far = 5000;
  double nearest = -1;
  if (!state_.overlays) return nearest;
  for (const sim::Overlay& one : *state_.overlays) {
    if (!one.surface || one.holder >= 0) continue;
    haptics::FacetHit hit;
    int looked = 0;
    if (one.surface->cast(one.place.local_from_world(ray.origin),
                          one.place.local_from_world(ray.origin + k_far * ray.direction), true, false, hit,
                          looked) &&
        (nearest < 0 || k_far * hit.t < nearest))
      nearest = k_far * hit.t;
  }
  return nearest;
}

bool OperationController::grab_point() {
  const std::optional<dvec3> at = touched();
  if (!at || !state_.overlays) return false;
  double nearest = std::max(4.0, 0.015 * reach_);  // mm, seen from afar more
  for (const sim::Overlay& one : *state_.overlays)
    for (const sim::Overlay::Handle& handle : one.handles)
      if (const double far = glm::length(handle.at - *at); far < nearest)
        nearest = far, grabbed_ = handle.move, dragged_to_ = handle.at;
  return has_point();
}

/// Some times a second, so that the outline is seen to follow.
void OperationController::drag_point() {
  constexpr int k_every = 3;
  const std::optional<dvec3> at = touched();
  if (!has_point() || !at || ++frames_since_drag_ < k_every || glm::length(*at - dragged_to_) < 0.2) return;
  for (const sim::Field& field : grabbed_.schema().fields) {
    const sim::FieldPlace place = field.place(grabbed_.data());
    if (auto* const* point = std::get_if<dvec3*>(&place); point && field.name == "at") **point = *at;
  }
  apply(grabbed_);
  dragged_to_ = *at;
  frames_since_drag_ = 0;
}

std::optional<dvec3> OperationController::touched() const {
  if (state_.newest.has_contact) return state_.newest.proxy_world;
  if (is_over_bone_) return state_.newest.pose.position_world;
  return std::nullopt;
}

/// Returns how far along the ray a tool may go that nothing holds, at most `along`: it stays off every
/// structure that must not be touched.
double OperationController::above_soft(const Ray& ray, double along) const {
  constexpr double k_margin = 0.5;  // mm: of the way from one place to the next
  constexpr int k_most_steps = 20;
  const ToolLook look = look_of(state_.tool);
  const double radius = std::max(state_.tool_radius, look.radius);
  // The middle of the tool's end: a ball is held there, another tool by its lowest point.
  const dvec3 middle = look.is_ball && state_.tool_radius > 0 ? dvec3(0) : radius * shaft();
  for (int i = 0; i < k_most_steps; ++i) {
    double clearance = 1e9;
    for (const auto& structure : live_.engine().forbidden())
      clearance =
          std::min(clearance, structure->clearance({ray.origin + along * ray.direction + middle, radius}, 0));
    if (clearance >= k_margin) break;
    along -= std::max(0.1, k_margin - clearance);
  }
  return along;
}

void OperationController::follow_cursor() {
  // The hand's request: on the surface under the cursor, and into it while the button is down.
  const Ray ray = viewport_.ray_at(x_, y_);
  const Viewport::RestingPlace rest = viewport_.resting_place(*version_, ray);
  double hit = is_pressed_ ? viewport_.distance_to_solid(*version_, ray) : rest.distance;
  bool is_soft = !is_pressed_ && rest.is_soft;
  if (const double body = distance_to_bodies(ray); body >= 0 && (hit < 0 || body < hit))
    hit = body, is_soft = false;
  // A tool that works and came through goes no farther: not to the far side, which is seen through its hole.
  constexpr double k_through = 10;  // mm
  if (is_pressed_ && is_over_bone_ && hit > reach_ + k_through) hit = reach_;
  if (hit >= 0) reach_ = hit;
  is_over_bone_ = hit >= 0;
  const double middle = state_.tool_radius;  // of a round tool, above what it touches
  double along =
      hit >= 0 ? hit - middle + (is_pressed_ ? depth_mm_ : 0.3) : std::max(0.0, reach_ - middle - 8);
  // A craniotome stands as the bone around it lies, not as that under a cursor that is ahead.
  const bool is_led = guide_.is_holding() && look_of(state_.tool).foot.kind == FootTool::Kind::craniotome;
  follow_surface(is_led ? Ray{ray.origin, glm::normalize(state_.newest.proxy_world - ray.origin)} : ray,
                 is_over_bone_ || is_led);
  if (follow_guide(ray, hit)) return;
  if (is_soft) along = above_soft(ray, hit - middle);
  const dvec3 request = ray.origin + along * ray.direction;
  const dvec3 up(0, 0, 1);
  constexpr double k_roll = 3.14159265358979 / 12;
  mouse_.set(request, glm::dquat(up, shaft()) * glm::angleAxis(k_roll * roll_, up), is_pressed_ && hit >= 0);
  // A cursor that jumps lifts the stylus over; it is not dragged through the bone.
  constexpr double k_jump_mm = 8;
  if (glm::length(request - request_) > k_jump_mm) {
    const double above =
        hit >= 0 ? std::max(0.0, hit - middle - 1.5 * scene_->base->frame.diagonal_mm()) : along;
    live_.set_down(scene_->base->frame.volume_from_world(ray.origin + above * ray.direction));
    mouse_.jump();
  }
  request_ = request;
}

}  // namespace trephine::view
