#include "haptics/hardware/device_exchange.h"

namespace trephine::haptics {

namespace {

constexpr double k_stalled_seconds = 0.05;  // age of the servo's last wrench at which the force ends

}  // namespace

void DeviceExchange::restart() noexcept {
  sent_ = last_ = {};
  newest_ = {};
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
  return seconds_now() - newest_.seconds <= k_stalled_seconds ? newest_.wrench : Wrench();
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
