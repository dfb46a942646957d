#include "haptics/device/mapped_device.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <string>
#include <utility>

#include "volume/base/text.h"

namespace trephine::haptics {

using glm::dvec3;

namespace {

/// Returns false for a pose that is not finite, or farther than any device reaches.
bool is_plausible(const Pose& pose) noexcept {
  constexpr double k_farthest = 1e6;  // mm
  const glm::dquat& q = pose.orientation;
  return glm::length(pose.position_world) < k_farthest && std::isfinite(q.w + q.x + q.y + q.z);
}

}  // namespace

MappedDevice::MappedDevice(std::shared_ptr<Device> device, const WorkspaceMap& map)
    : device_(std::move(device)), map_(map) {}

Status check(const WorkspaceMap& map) {
  if (map.scale >= 0.1 && map.scale <= 10) return std::nullopt;
  return Error{.what = "the scale of the device is out of range",
               .where = "device",
               .found = rounded_text(map.scale),
               .expected = "0.1 to 10"};
}

Status MappedDevice::open() {
  if (Status error = check(map_)) return error;
  has_anchor_ = is_clutched_ = is_lost_ = false;
  time_ = released_at_ = -1e9;
  workspace_.set({});
  if (Status error = device_->open()) return error;
  radius_ = capabilities().workspace_radius;
  return std::nullopt;
}

DeviceCapabilities MappedDevice::capabilities() const {
  DeviceCapabilities c = device_->capabilities();
  // The force is the same at a motion that is `scale` times as large.
  c.workspace_radius *= map_.scale;
  c.max_stiffness /= map_.scale;
  c.damping /= map_.scale;
  c.mass /= map_.scale;
  return c;
}

void MappedDevice::set_view(const DeviceView& view) noexcept { view_.set(view); }

bool MappedDevice::read(double t, Pose& pose) noexcept {
  Pose raw;
  if (!std::isfinite(t) || !device_->read(t, raw) || !is_plausible(raw)) {
    is_lost_ = true;
    return false;
  }
  if (std::exchange(is_lost_, false) || t < time_) released_at_ = t;  // t < time_: the clock began again
  const bool is_clutched = (raw.buttons & map_.clutch_mask) != 0;
  bool is_moved = !has_anchor_;  // the workspace
  const auto anchor = [&](const dvec3& world) {
    anchor_device_ = raw.position_world, anchor_world_ = world;
    is_moved = true;
  };
  if (const std::optional<DeviceView> view = view_.get()) {
    if (!has_anchor_) {
      anchor_device_ = dvec3(0), anchor_world_ = view->start_world;
      world_from_device_ = unit_of(view->world_from_device);
      position_world_ = anchor_world_ + world_from_device_ * (map_.scale * raw.position_world);
      has_anchor_ = true;
    } else if (const glm::dquat axes = unit_of(view->world_from_device); axes != world_from_device_) {
      world_from_device_ = axes;
      anchor(position_world_);
    }
  }
  if (!has_anchor_) return false;
  if (is_clutched || is_clutched_) anchor(position_world_);
  if (is_clutched_ && !is_clutched) released_at_ = t;
  is_clutched_ = is_clutched;
  time_ = t;
  const auto world_of = [&](const dvec3& p) {
    return anchor_world_ + world_from_device_ * (map_.scale * (p - anchor_device_));
  };
  position_world_ = world_of(raw.position_world);
  if (is_moved && radius_ > 0) workspace_.set({world_of(dvec3(0)), radius_});
  pose = raw;
  pose.position_world = position_world_;
  pose.orientation = world_from_device_ * raw.orientation;
  pose.buttons &= ~map_.clutch_mask;
  if (is_clutched_) pose.press(false);
  return true;
}

std::optional<Workspace> MappedDevice::workspace() const noexcept {
  const std::optional<Workspace> latest = workspace_.get();
  return latest && latest->radius > 0 ? latest : std::nullopt;
}

std::optional<dvec3> MappedDevice::fetch_jump() noexcept {
  const std::optional<dvec3> jump = device_->fetch_jump();
  if (!jump) return std::nullopt;
  return anchor_world_ + world_from_device_ * (map_.scale * (*jump - anchor_device_));
}

void MappedDevice::write(const Wrench& wrench) noexcept {
  double share = is_clutched_ || is_lost_ ? 0 : 1;
  if (map_.resume_seconds > 0) share *= std::clamp((time_ - released_at_) / map_.resume_seconds, 0.0, 1.0);
  const glm::dquat device_from_world = glm::conjugate(world_from_device_);
  device_->write(
      {share * (device_from_world * wrench.force_world), share * (device_from_world * wrench.torque_world)});
}

}  // namespace trephine::haptics
