#include "apps/view/mouse_device.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

namespace trephine::view {

MouseDevice::MouseDevice(const glm::dvec3& start)
    : sent_{.position = start}, shared_(sent_), request_(sent_), position_(start) {}

void MouseDevice::set(const glm::dvec3& request, const glm::dquat& turn, bool is_pressed,
                      const std::optional<glm::dvec3>& jump, const glm::dvec3& press) noexcept {
  const glm::dvec3 free = jump.value_or(glm::dvec3(0));
  for (const glm::dvec3& p : {request, free, press})
    if (!std::isfinite(p.x) || !std::isfinite(p.y) || !std::isfinite(p.z)) return;
  for (const double value : {turn.w, turn.x, turn.y, turn.z})
    if (!std::isfinite(value)) return;
  sent_.position = request - press, sent_.press = press;
  sent_.turn = turn, sent_.is_pressed = is_pressed;
  // Without a new jump, keep the point of the last jump: the servo may not have read it.
  if (jump) sent_.free = free, ++sent_.jumps;
  shared_.set(sent_);
}

void MouseDevice::release() noexcept {
  sent_.is_pressed = false;
  shared_.set(sent_);
}

bool MouseDevice::read(double t, haptics::Pose& pose) noexcept {
  bool is_jump = false;
  if (const std::optional<Request> newest = shared_.get()) {
    is_jump = newest->jumps != request_.jumps;
    // If frames are slow, requested positions are far apart: the time constant of a working tool grows, so
    // that it moves evenly between them.
    constexpr double k_share = 0.4, k_longest = 0.2;  // share of the time between two positions; s
    if (newest->position != request_.position) {
      time_constant_ =
          newest->is_pressed ? std::clamp(k_share * (t - moved_at_), k_seconds, k_longest) : k_seconds;
      moved_at_ = t;
    }
    request_ = *newest;
    if (is_jump) jump_ = request_.free;
  }
  constexpr double k_turn_seconds = 0.08;
  const double dt = t - time_;
  if (dt > 0) {
    position_ += dt / (dt + time_constant_) * (request_.position - position_);
    constexpr double k_press_speed = 60;  // mm/s
    const glm::dvec3 missing = request_.press - press_;
    const double length = glm::length(missing);
    const bool grows = glm::length(request_.press) > glm::length(press_);
    const double share = dt / (dt + k_seconds), most = k_press_speed * dt;
    press_ += (grows && share * length > most ? most / length : share) * missing;
    // Interpolate along the shorter arc, which never passes through a zero quaternion.
    const glm::dquat to = glm::dot(turn_, request_.turn) < 0 ? -request_.turn : request_.turn;
    turn_ = haptics::unit_of(turn_ + dt / (dt + k_turn_seconds) * (to - turn_));
  }
  if (is_jump) position_ = request_.position, turn_ = request_.turn, press_ = glm::dvec3(0);
  time_ = t;
  pose.position_world = position_ + press_;
  pose.orientation = turn_;
  pose.press(request_.is_pressed);
  if (is_pressed_read_ && !request_.is_pressed) released_at_ = t;
  is_pressed_read_ = request_.is_pressed;
  return true;
}

}  // namespace trephine::view
