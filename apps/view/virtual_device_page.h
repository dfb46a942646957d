// Window of a virtual device: the tool in its workspace, moved by mouse and keys, with the forces it
// receives.
#pragma once

#include <functional>
#include <optional>
#include <string>

#include "apps/workbench/virtual_device.h"

namespace trephine::view {

struct VirtualDevicePageOptions {
  std::string language;  ///< one of k_languages; empty: that of the system, or of the last window
  std::string device;    ///< name by which other programs open the device, such as "remote:0"
  bool is_moved = true;  ///< by mouse and keys; false: by a motion or an attached device
  std::optional<double> seconds = std::nullopt;  ///< closes the window after this time
  std::function<bool()> should_close = [] { return false; };
  std::string screenshot = {};  ///< file of a picture of the window at its end; empty: none
};

/// Shows the window until the user closes it. Error without a display or the full window.
Status show_virtual_device(workbench::VirtualDeviceHost& host, const VirtualDevicePageOptions& options);

/// Entry point of the window's library.
using ShowVirtualDevice = Status (*)(workbench::VirtualDeviceHost&, const VirtualDevicePageOptions&);
inline constexpr const char* k_virtual_device_entry = "trephine_show_virtual_device";

}  // namespace trephine::view
