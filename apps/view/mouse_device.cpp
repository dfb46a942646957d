#include "apps/view/mouse_device.h"

namespace trephine::view {

MouseDevice::MouseDevice(const glm::dvec3& start)
    : x_(start.x), y_(start.y), z_(start.z), wish_(start), position_(start) {}

void MouseDevice::set(const glm::dvec3& wish, bool is_pressed) noexcept {
  sequence_.fetch_add(1);
  x_.store(wish.x);
  y_.store(wish.y);
  z_.store(wish.z);
  is_pressed_.store(is_pressed);
  sequence_.fetch_add(1);
}

bool MouseDevice::read(double t, haptics::Pose& pose) noexcept {
  for (int attempt = 0; attempt < 3; ++attempt) {
    const unsigned before = sequence_.load();
    const glm::dvec3 wish(x_.load(), y_.load(), z_.load());
    const bool is_pressed = is_pressed_.load();
    if (before % 2 == 0 && sequence_.load() == before) {
      wish_ = wish;
      pressed_ = is_pressed;
      break;
    }
  }
  constexpr double k_seconds = 0.015;
  const double dt = t - time_;
  if (dt > 0) position_ += dt / (dt + k_seconds) * (wish_ - position_);
  if (is_jumping_.exchange(false)) position_ = wish_;
  time_ = t;
  pose.position_world = position_;
  pose.orientation = {1, 0, 0, 0};
  pose.press(pressed_);
  return true;
}

}  // namespace trephine::view
