#include "apps/view/mouse_device.h"

#include <cmath>
#include <iterator>
#include <utility>

namespace trephine::view {

MouseDevice::MouseDevice(const glm::dvec3& start)
    : shared_{start.x, start.y, start.z, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0},
      request_(start),
      position_(start) {}

void MouseDevice::set(const glm::dvec3& request, const glm::dquat& turn, bool is_pressed,
                      const std::optional<glm::dvec3>& jump) noexcept {
  const glm::dvec3 free = jump.value_or(glm::dvec3(0));
  const double values[] = {request.x, request.y, request.z, turn.w, turn.x,
                           turn.y,    turn.z,    free.x,    free.y, free.z};
  for (const double value : values)
    if (!std::isfinite(value)) return;
  sequence_.fetch_add(1);
  // The point of an earlier jump remains until it is read.
  const std::size_t count = std::size(values) - (jump ? 0 : 3);
  for (std::size_t i = 0; i < count; ++i) shared_[i].store(values[i]);
  if (jump) shared_.back().store(shared_.back().load() + 1);
  is_pressed_.store(is_pressed);
  sequence_.fetch_add(1);
}

bool MouseDevice::read(double t, haptics::Pose& pose) noexcept {
  bool is_jump = false;
  for (int attempt = 0; attempt < 3; ++attempt) {
    const unsigned before = sequence_.load();
    double values[11];
    for (std::size_t i = 0; i < shared_.size(); ++i) values[i] = shared_[i].load();
    const bool is_pressed = is_pressed_.load();
    if (before % 2 == 0 && sequence_.load() == before) {
      request_ = {values[0], values[1], values[2]};
      requested_turn_ = glm::dquat(values[3], values[4], values[5], values[6]);
      pressed_ = is_pressed;
      is_jump = std::exchange(jumps_, values[10]) != values[10];
      if (is_jump) jump_ = {values[7], values[8], values[9]};
      break;
    }
  }
  constexpr double k_seconds = 0.015, k_turn_seconds = 0.08;
  const double dt = t - time_;
  if (dt > 0) {
    position_ += dt / (dt + k_seconds) * (request_ - position_);
    // Interpolate along the shorter arc, which never passes through a zero quaternion.
    const glm::dquat to = glm::dot(turn_, requested_turn_) < 0 ? -requested_turn_ : requested_turn_;
    turn_ = haptics::unit_of(turn_ + dt / (dt + k_turn_seconds) * (to - turn_));
  }
  if (is_jump) position_ = request_, turn_ = requested_turn_;
  time_ = t;
  pose.position_world = position_;
  pose.orientation = turn_;
  pose.press(pressed_);
  if (is_pressed_read_ && !pressed_) released_at_ = t;
  is_pressed_read_ = pressed_;
  return true;
}

}  // namespace trephine::view
