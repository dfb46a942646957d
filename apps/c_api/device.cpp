// Functions of devices of the C interface.
#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "apps/c_api/device_handle.h"

using namespace trephine;
using c_api::bad;
using c_api::guarded;

namespace {

Result<HandDevice> open(const char* name, const trephine_device_options* options) {
  if (name == nullptr) return bad("an argument is missing", "NULL", "a device's name");
  DeviceOptions choice;
  if (options) {
    if (options->pedal) choice.pedal = options->pedal;
    if (options->scale != 0) choice.scale = options->scale;
    if (!c_api::is_valid_position(options->start))
      return bad("the start is invalid", "a coordinate that is not finite or beyond 100 km",
                 "a position in mm");
    choice.view.start_world = {options->start[0], options->start[1], options->start[2]};
    const glm::dquat rotation(options->rotation[0], options->rotation[1], options->rotation[2],
                              options->rotation[3]);
    if (rotation != glm::dquat(0, 0, 0, 0)) {
      if (!(std::abs(glm::dot(rotation, rotation) - 1) < 1e-6))
        return bad("the rotation is invalid", "a quaternion that is not of unit length", "w x y z, or all 0");
      choice.view.world_from_device = rotation;
    }
    if (options->notice)
      choice.notice = [notice = options->notice, user = options->user](const std::string& text) {
        notice(text.c_str(), user);
      };
  }
  return HandDevice::open(name, choice);
}

}  // namespace

extern "C" {

trephine_device* trephine_device_open(const char* name, const trephine_device_options* options,
                                      trephine_error* error) {
  std::unique_ptr<trephine_device> result;
  const int code = guarded(error, [&]() -> Status {
    Result<HandDevice> opened = open(name, options);
    if (!opened) return opened.error();
    result = std::make_unique<trephine_device>(std::move(opened).value());
    return std::nullopt;
  });
  return code == TREPHINE_OK ? result.release() : nullptr;
}

void trephine_device_close(trephine_device* device) { delete device; }

int trephine_device_get_info(const trephine_device* device, trephine_device_info* info) {
  if (device == nullptr || info == nullptr) return TREPHINE_BAD_ARGUMENT;
  const DeviceCapabilities& known = device->device.capabilities();
  *info = {};
  std::copy_n(known.name.begin(), std::min(known.name.size(), sizeof info->name - 1), info->name);
  info->degrees_of_freedom = known.degrees_of_freedom;
  info->max_force = known.max_force;
  info->max_torque = known.max_torque;
  info->max_stiffness = known.max_stiffness;
  info->workspace_radius = known.workspace_radius;
  return TREPHINE_OK;
}

int trephine_device_read(trephine_device* device, double t, trephine_pose* pose) {
  if (device == nullptr || pose == nullptr) return TREPHINE_BAD_ARGUMENT;
  const std::optional<Pose> read = device->device.read(t);
  if (!read) return TREPHINE_FAILED;
  for (int a = 0; a < 3; ++a) pose->position[a] = read->position_world[a];
  const glm::dquat q = haptics::unit_of(read->orientation);
  pose->rotation[0] = q.w, pose->rotation[1] = q.x, pose->rotation[2] = q.y, pose->rotation[3] = q.z;
  pose->buttons = read->buttons;
  return TREPHINE_OK;
}

int trephine_device_write(trephine_device* device, const trephine_touch* touch, const double torque[3]) {
  if (device == nullptr) return TREPHINE_BAD_ARGUMENT;
  Touch rendered;
  if (touch) rendered.force_world = {touch->force[0], touch->force[1], touch->force[2]};
  if (torque) rendered.torque_world = {torque[0], torque[1], torque[2]};
  device->device.write(rendered);
  return TREPHINE_OK;
}

}  // extern "C"
