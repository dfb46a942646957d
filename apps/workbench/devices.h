// Devices of this build, by name.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "apps/workbench/listener.h"
#include "haptics/device/device_kind.h"

namespace trephine::workbench {

struct DeviceChoice {
  /// "mouse", "falcon", "touch", "spacemouse:1", "playback:PATH.csv", "virtual:PATH.csv"; empty: that of the
  /// user's devices.toml, or else the mouse.
  std::string device;
  std::string left;   ///< device of the left hand, as `device`, but not the mouse; empty: one hand
  std::string pedal;  ///< "pedal", "pedal:1", "pedal:/dev/input/event5"; empty: no pedal
  double scale = 1;   ///< motion of the tool per motion of the device; 1 for devices that are not hardware
};

/// Devices of a choice, which are not open yet.
struct ChosenDevices {
  std::shared_ptr<haptics::Device> device;  ///< null: the mouse, which belongs to the window
  std::shared_ptr<haptics::Device> left;    ///< null: one hand
  std::shared_ptr<haptics::Device>
      pedal;  ///< pedal that is used with the mouse; null with another device, which then includes the pedal
};
/// Returns 2 with a device of the left hand, else 1.
inline std::size_t hand_count_of(const ChosenDevices& chosen) noexcept { return chosen.left ? 2 : 1; }
/// Makes the devices of a choice, without opening them. Error on unknown names, a path that cannot be read,
/// an invalid scale, or a library of drivers that is needed but not installed.
Result<ChosenDevices> make_devices(const DeviceChoice& choice, const Listener& listener);

/// Opens and closes the devices once. An error, or the instructions of a device that must be homed, thus
/// appear before the window opens.
Status try_devices(const ChosenDevices& chosen);

/// Returns the capabilities of the hands' devices; nothing for the mouse. Call after try_devices(): some
/// devices report their limits only when they are open.
std::vector<haptics::DeviceCapabilities> capabilities_of(const ChosenDevices& chosen);

/// Loads the library of drivers. Error if it is not installed.
Result<std::span<const haptics::DeviceKind>> hardware_kinds();
/// Returns the services of this program for drivers.
haptics::DeviceHost device_host(const Listener& listener);

}  // namespace trephine::workbench
