// Input devices of Linux (evdev), for pedals.
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
/// Returns true if the reports of a HID descriptor begin with a number.
bool has_report_number(std::span<const std::uint8_t> descriptor) noexcept;
/// Opens an input device (/dev/input/event0) for this program alone, so that no other program receives its
/// keys, or a device of raw reports (/dev/hidraw0).
Result<InputFile> open_input(const std::string& node);

}  // namespace trephine::haptics
