#include "haptics/hardware/device_exchange.h"

#include <algorithm>
#include <utility>

namespace trephine::haptics {

namespace {

constexpr double k_stalled_seconds = 0.05;  // age of the servo's last wrench at which the force ends
constexpr double k_resume_seconds = 0.1;

}  // namespace

void DeviceExchange::restart() noexcept {
  sent_ = last_ = {};
  newest_ = {};
  is_paused_ = false, resumed_at_ = -1e9;
  report_.set(sent_);
  request_.set(newest_);
  silence_.restart();
}

void DeviceExchange::report(const glm::dvec3& position, const glm::dquat& orientation,
                            std::uint32_t buttons) noexcept {
  sent_ = {position, orientation, buttons, sent_.count + 1, false};
  report_.set(sent_);
}

void DeviceExchange::report_loss() noexcept {
  sent_.is_lost = true;
  report_.set(sent_);
}

Wrench DeviceExchange::wrench() noexcept {
  if (const auto request = request_.get()) newest_ = *request;
  const double now = seconds_now();
  // Before the first write there is no pause: the force of the servo begins gradually by itself.
  const bool has_begun = newest_.seconds > -1e8, is_paused = now - newest_.seconds > k_stalled_seconds;
  if (std::exchange(is_paused_, has_begun && is_paused) && !is_paused) resumed_at_ = now;
  if (is_paused) return {};
  const double share = std::min(1.0, (now - resumed_at_) / k_resume_seconds);
  return {share * newest_.wrench.force_world, share * newest_.wrench.torque_world};
}

bool DeviceExchange::read(double t, Pose& pose) noexcept {
  if (const auto report = report_.get()) last_ = *report;
  if (last_.is_lost || last_.count == 0 || silence_.has_expired(t, last_.count)) return false;
  pose.position_world = last_.position;
  pose.orientation = last_.orientation;
  pose.buttons = last_.buttons;
  return true;
}

void DeviceExchange::write(const Wrench& wrench) noexcept { request_.set({wrench, seconds_now()}); }

}  // namespace trephine::haptics
