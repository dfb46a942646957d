// HandDevice: opens a device of the workbench for a program.
#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <utility>

#include "apps/api/operation.h"
#include "apps/workbench/devices.h"

namespace trephine {

namespace {

/// Returns a vector no longer than `limit`; zero if it is not finite.
glm::dvec3 limited(const glm::dvec3& vector, double limit) noexcept {
  const double length = glm::length(vector);
  if (!std::isfinite(length)) return glm::dvec3(0);
  return length > limit ? limit / length * vector : vector;
}

}  // namespace

Result<HandDevice> HandDevice::open(const std::string& name, const DeviceOptions& options) {
  if (name.empty() || name == "mouse")
    return Error{.what = "this device needs a window",
                 .where = "device",
                 .found = name.empty() ? "no name" : name,
                 .expected = "a haptic device, a 3-D mouse, playback:PATH.csv or virtual:PATH.csv",
                 .remedy = "choose one of these; 'trephine doctor --devices' lists the connected devices"};
  workbench::Listener listener;
  if (options.notice) listener.notice = options.notice;
  workbench::DeviceChoice choice;
  choice.device = name, choice.pedal = options.pedal, choice.scale = options.scale;
  auto made = workbench::make_devices(choice, listener);
  if (!made) return made.error();
  std::shared_ptr<haptics::Device> device = std::move(made.value().device);
  device->set_view(options.view);
  if (Status error = device->open()) return *error;
  DeviceCapabilities capabilities = device->capabilities();
  return HandDevice(std::move(device), std::move(capabilities));
}

HandDevice& HandDevice::operator=(HandDevice&& other) noexcept {
  if (this == &other) return *this;
  if (device_) device_->close();
  device_ = std::move(other.device_);
  capabilities_ = std::move(other.capabilities_);
  is_lost_ = other.is_lost_, time_ = other.time_, recovered_at_ = other.recovered_at_;
  return *this;
}

HandDevice::~HandDevice() {
  if (device_) device_->close();
}

std::optional<Pose> HandDevice::read(double t) noexcept {
  Pose pose;
  time_ = t;
  if (!device_ || !device_->read(t, pose)) {
    is_lost_ = true;
    return std::nullopt;
  }
  if (std::exchange(is_lost_, false)) recovered_at_ = t;
  return pose;
}

void HandDevice::write(const Touch& touch) noexcept {
  if (!device_) return;
  constexpr double k_resume = 0.1;  // s
  const double share = is_lost_ ? 0 : std::clamp((time_ - recovered_at_) / k_resume, 0.0, 1.0);
  device_->write({share * limited(touch.force_world, capabilities_.max_force),
                  share * limited(touch.torque_world, capabilities_.max_torque)});
}

}  // namespace trephine
