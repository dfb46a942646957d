// DeviceFile: the devices of a user, devices.toml.
#pragma once

#include <optional>
#include <string>

#include "volume/base/error.h"

namespace trephine::data_tools {

struct DeviceSettings {
  std::string device, pedal;  ///< names of devices; empty: none
  double scale = 1;           ///< motion of the tool per motion of the device
};

/// Reads the settings; nullopt if there is no such file. Error: unknown keys, values of another type or out
/// of range.
Result<std::optional<DeviceSettings>> read_device_settings(const std::string& path);

}  // namespace trephine::data_tools
