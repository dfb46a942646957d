#include "haptics/hardware/spacemouse_device.h"

#include <array>

namespace trephine::haptics {

SpaceMouseDevice::SpaceMouseDevice(OpenHidLink open_link, const RateControl& control)
    : open_link_(std::move(open_link)), control_(control), pose_(control) {}

Status SpaceMouseDevice::open() {
  close();
  auto link = open_link_();
  if (!link) return link.error();
  link_ = std::move(link).value();
  parser_ = SpaceMouseParser();
  shared_.set({});
  pose_ = RatePose(control_);
  last_ = {};
  has_time_ = false;
  constexpr std::array<std::uint8_t, 2> k_light_on{4, 1};  // output report 4: the light
  link_->write(k_light_on);
  thread_.start([this] { return receive(); });
  return std::nullopt;
}

void SpaceMouseDevice::close() noexcept {
  thread_.stop();
  if (!link_) return;
  constexpr std::array<std::uint8_t, 2> k_light_off{4, 0};
  link_->write(k_light_off);
  link_.reset();
}

DeviceCapabilities SpaceMouseDevice::capabilities() const {
  return {.name = "SpaceMouse",
          .degrees_of_freedom = 6,
          .max_force = 0,
          .max_stiffness = 0,
          .workspace_radius = control_.radius};
}

/// Reads one report. Returns false after the device was unplugged.
bool SpaceMouseDevice::receive() {
  constexpr int k_rest_ms = 30;  // about two periods of the device's reports, 16 ms each
  std::array<std::uint8_t, 64> report;
  std::size_t count = 0;
  switch (link_->read(report, count, k_rest_ms)) {
    case LinkResult::done:
      if (!parser_.add(std::span(report).first(std::min(count, report.size())))) return true;
      break;
    case LinkResult::timed_out:
      parser_.rest();
      break;
    case LinkResult::disconnected:
    case LinkResult::failed:
      shared_.set({{}, true});
      return false;
  }
  shared_.set({parser_.state(), false});
  return true;
}

bool SpaceMouseDevice::read(double t, Pose& pose) noexcept {
  if (const auto shared = shared_.get()) last_ = *shared;
  if (last_.is_lost) return false;
  if (has_time_) pose_.move(last_.state, t - time_);
  time_ = t, has_time_ = true;
  pose.position_world = pose_.position();
  pose.orientation = pose_.orientation();
  pose.buttons = last_.state.buttons;
  return true;
}

}  // namespace trephine::haptics
