// Input devices of Linux (evdev): pedals, and the mouse that the kernel makes of a SpaceMouse.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "haptics/hardware/pedal_device.h"

namespace trephine::haptics {

/// A pedal that is connected to this computer.
struct PedalNode {
  std::string node, name;      ///< file, such as /dev/input/event3; name that the device reports
  bool is_accessible = false;  ///< this user may read the file
};

/// Returns the connected foot pedals whose USB vendor and product this version knows.
std::vector<PedalNode> find_pedals();
/// Returns the input devices (/dev/input/event3) that the kernel makes of a HID device. `device`: its folder
/// in sysfs, such as /sys/class/hidraw/hidraw0/device.
std::vector<std::string> event_files_of(const std::string& device);

/// Keeps input devices from other programs until it is destroyed. Files that this user may not open, and
/// those that another program holds, are left alone.
class InputGrab {
 public:
  InputGrab() = default;
  explicit InputGrab(const std::vector<std::string>& event_files);
  ~InputGrab();
  InputGrab(const InputGrab&) = delete;
  InputGrab& operator=(const InputGrab&) = delete;
  /// Returns the number of devices that are held.
  [[nodiscard]] std::size_t count() const noexcept { return files_.size(); }

 private:
  std::vector<int> files_;
};

/// Returns true if the reports of a HID descriptor begin with a number.
bool has_report_number(std::span<const std::uint8_t> descriptor) noexcept;
/// Opens an input device (/dev/input/event0) for this program alone, so that no other program receives its
/// keys, or a device of raw reports (/dev/hidraw0).
Result<InputFile> open_input(const std::string& node);

}  // namespace trephine::haptics
