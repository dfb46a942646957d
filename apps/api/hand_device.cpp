// HandDevice: opens a device of the workbench for a program.
#include <cmath>
#include <utility>

#include "apps/api/operation.h"
#include "apps/workbench/devices.h"
#include "haptics/force/limited.h"

namespace trephine {

namespace {

/// Returns a vector within a limit of its length; zero if it is not finite.
glm::dvec3 rendered(const glm::dvec3& vector, double limit) noexcept {
  return std::isfinite(glm::length(vector)) ? haptics::limited(vector, limit) : glm::dvec3(0);
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
  return *this;
}

HandDevice::~HandDevice() {
  if (device_) device_->close();
}

std::optional<Pose> HandDevice::read(double t) noexcept {
  Pose pose;
  if (!device_ || !std::isfinite(t) || !device_->read(t, pose)) return std::nullopt;
  return pose;
}

void HandDevice::write(const Touch& touch) noexcept {
  if (!device_) return;
  device_->write({rendered(touch.force_world, capabilities_.max_force),
                  rendered(touch.torque_world, capabilities_.max_torque)});
}

}  // namespace trephine
