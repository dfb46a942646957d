// DeviceKind: a kind of hardware that a library of drivers provides.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "haptics/device/device.h"

namespace trephine::haptics {

// Call all functions on the thread that opens the devices.

/// One result of a check of this machine, with its remedy.
struct DeviceCheck {
  std::string found, remedy = {};
  bool is_fault = false;
  std::string node = {};  ///< file of the device; empty: the result is not about one device
};

/// Services of the program for drivers.
struct DeviceHost {
  std::function<void(const std::string&)>
      notice;  ///< called on the opening thread with instructions for the user
  /// Called on the opening thread while it waits for the user. Returns true if the user cancelled.
  std::function<bool()> should_stop = [] { return false; };
  std::string settings_folder;  ///< of the user, with files such as the firmware of a device; may be empty
};

/// Returns the error of a device whose opening the user cancelled.
inline Error cancelled(const std::string& device) {
  return {.what = "the opening of the device was cancelled",
          .where = device + ": cancelled",
          .remedy = "open it again, or use the mouse",
          .kind = ErrorKind::interrupted};
}

struct DeviceKind {
  std::string name;         ///< as users write it: "falcon"
  std::string description;  ///< one line
  bool has_pose = true;     ///< false: buttons and axes only, as a pedal
  /// Creates a device without opening it. `selector`: text after the name and a colon, such as an index; may
  /// be empty. The pose is in the device frame (see MappedDevice).
  std::function<Result<std::shared_ptr<Device>>(const std::string& selector, const DeviceHost& host)> make;
  /// Checks what is plugged in and what prevents its use. Opens nothing.
  std::function<std::vector<DeviceCheck>(const DeviceHost& host)> check;
  /// Returns a sentence with the software of the vendor that is missing on this machine, whether or not a
  /// device is plugged in; empty if nothing is missing.
  std::function<std::string(const DeviceHost& host)> missing_software;
};

/// Function that a library of drivers exports as "trephine_device_kinds". Returns the first kind, and sets
/// `count` to the number of kinds.
using DeviceKindsFunction = const DeviceKind* (*)(std::size_t* count);

}  // namespace trephine::haptics
