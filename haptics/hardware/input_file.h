// Input devices of Linux (evdev), for pedals.
#pragma once

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
/// Opens an input device for this program alone, so that no other program receives its keys.
Result<InputFile> open_input(const std::string& node);

}  // namespace trephine::haptics
