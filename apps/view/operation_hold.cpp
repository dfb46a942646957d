// Holding the tool of a mouse: its shaft, its tilt, its tip moved by keys, its guide.
#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>

#include "apps/view/operation_controller.h"
#include "apps/view/tool_look.h"
#include "modules/cross_section/section.h"

namespace trephine::view {

using glm::dvec3;
using workbench::Clock;
using workbench::EventLevel;
using workbench::seconds_since;

/// A tool is held upright on the surface, one whose end is a ball so that its work is seen. While it works
/// the hand turns it no faster than a wrist.
void OperationController::follow_surface(const Ray& ray, bool is_over_bone) {
  const ToolLook look = look_of(state_.tool);
  const bool is_kerrison = look.foot.kind == FootTool::Kind::kerrison;
  if (!is_over_bone && !is_kerrison) return;
  if (hold_ == Hold::fixed) return;
  std::optional<dvec3> normal = viewport_.facing(*untouched_, ray);
  // Near an edge bone has no direction of its own, and the way to it is the one that is seen.
  if (is_kerrison) normal = glm::normalize(normal.value_or(-ray.direction) - ray.direction);
  if (!normal) return;
  const dvec3 target = hold_ == Hold::viewer ? -ray.direction
                       : look.is_ball        ? Viewport::held_at(*normal, -ray.direction)
                                             : *normal;
  if (!is_pressed_) {
    shaft_ = target;
    return;
  }
  constexpr double k_most = 0.01;  // radians a frame
  const double angle = std::acos(std::clamp(glm::dot(shaft_, target), -1.0, 1.0));
  if (angle > 1e-6) shaft_ = glm::normalize(shaft_ + std::min(1.0, k_most / angle) * (target - shaft_));
}

void OperationController::tilt(double right, double up) {
  constexpr double k_radians = 3.14159265358979 / 180, k_most = 75;  // degrees
  const volume::Eye eye = viewport_.eye();
  const dvec3 toward = right * glm::cross(eye.forward, eye.up) + up * eye.up;
  const dvec3 axis = glm::cross(shaft(), toward);
  const double angle = std::hypot(right, up);
  if (angle <= 0 || glm::length(axis) < 0.05 * angle) return;
  const glm::dquat before = tilt_;
  tilt_ = glm::normalize(glm::angleAxis(k_radians * angle, glm::normalize(axis)) * tilt_);
  if (tilted() > k_most) tilt_ = before;
}

double OperationController::tilted() const {
  return std::acos(std::clamp(glm::dot(shaft(), shaft_), -1.0, 1.0)) * 180 / 3.14159265358979;
}

OperationController::Hold OperationController::hold_next() {
  hold_ = static_cast<Hold>((static_cast<int>(hold_) + 1) % 3);
  if (hold_ == Hold::fixed) shaft_ = shaft();
  tilt_ = {1, 0, 0, 0};
  return hold_;
}

void OperationController::move_tip(double right, double up) {
  const volume::Eye eye = viewport_.eye();
  const double height = eye.height * reach_ / std::max(1.0, eye.distance);  // mm, of the picture at the tip
  const double width = height * eye.columns / eye.rows;
  x_ = std::clamp(x_ + right / width, 0.0, 1.0);
  y_ = std::clamp(y_ + up / height, 0.0, 1.0);
}

/// Returns where the ray meets bone, or, where it passes an edge of bone to what lies behind, a place of that
/// edge's surface next to it.
std::optional<dvec3> OperationController::bone_beside(const Ray& ray, double hit) {
  constexpr int k_rays = 8;
  constexpr double k_around = 4, k_behind = 5;  // mm
  const dvec3 other = std::abs(ray.direction.z) < 0.9 ? dvec3(0, 0, 1) : dvec3(0, 1, 0);
  const dvec3 a = glm::normalize(glm::cross(ray.direction, other)), b = glm::cross(a, ray.direction);
  std::optional<dvec3> best;
  if (hit >= 0) best = ray.origin + hit * ray.direction;
  double nearest = hit >= 0 ? hit - k_behind : 1e9;
  for (int i = 0; i < k_rays; ++i) {
    const double angle = 2 * 3.14159265358979 * i / k_rays;
    const dvec3 off = k_around * (std::cos(angle) * a + std::sin(angle) * b);
    const double beside = viewport_.distance_to_solid(*version_, {ray.origin + off, ray.direction});
    if (beside >= 0 && beside < nearest) nearest = beside, best = ray.origin + off + beside * ray.direction;
  }
  return best;
}

/// Holds a tool with a foot by its guide, where that has a place for it.
bool OperationController::follow_guide(const Ray& ray, double hit) {
  const bool was_holding = guide_.is_holding(), is_pressed = std::exchange(has_click_, false) || is_pressed_;
  const FootTool tool = look_of(state_.tool).foot;
  if (tool.kind == FootTool::Kind::none && !was_holding) return viewport_.mark_edge({}), false;
  // By labels too: a window of intensities leaves marrow open.
  const auto bone_of = [this](const volume::Version& version) {
    return [this, &version, labelled = volume::BoneAt(*scene_->base, {}, &version)](const dvec3& at) {
      const dvec3 p = scene_->base->frame.volume_from_world(at);
      return (version.distance(p) > 0 &&
              std::any_of(solids_.begin(), solids_.end(),
                          [&](const volume::Field& f) { return f.value(p) >= 0; })) ||
             labelled.by_labels(at);
    };
  };
  ToolGuide::Input input;
  input.tool = tool;
  input.eye = ray.origin, input.direction = ray.direction;
  if (hit >= 0) input.surface = ray.origin + hit * ray.direction;
  if (tool.kind == FootTool::Kind::kerrison) input.surface = bone_beside(ray, hit);
  if (const double old = viewport_.distance_to_solid(*untouched_, ray); old >= 0)
    input.old_surface = ray.origin + old * ray.direction;
  input.shaft = shaft();
  input.tip = state_.newest.has_contact ? state_.newest.proxy_world : state_.newest.pose.position_world;
  input.is_pressed = is_pressed;
  input.seconds = seconds_since(std::exchange(guided_at_, Clock::now()));
  input.version = version_;
  const std::optional<ToolGuide::Pose> pose = guide_.follow(bone_of(*version_), bone_of(*untouched_), input);
  viewport_.mark_edge(guide_.edge());
  if (std::string why = guide_.take_message(); !why.empty())
    notices_.add({seconds(), static_cast<double>(state_.newest.tick) / options_.rate_hz, EventLevel::refusal,
                  "Not possible here: " + why});
  if (was_holding && !pose) request_ = dvec3(1e9);  // lifted off
  if (!pose) return false;
  mouse_.set(pose->at_world, pose->turn, pose->is_pressed);
  if (pose->is_jump) {
    live_.set_down(scene_->base->frame.volume_from_world(pose->at_world));
    mouse_.jump();
  }
  return true;
}

}  // namespace trephine::view
