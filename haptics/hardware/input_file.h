// Input devices of Linux (evdev), for pedals.
#pragma once

#include <string>
#include <vector>

#include "haptics/hardware/pedal_device.h"

namespace trephine::haptics {

struct PedalNode {
  std::string node, name;  ///< /dev/input/event3; the name that the device reports
  bool is_accessible = false;
};

/// Returns the foot pedals that this version knows by their vendor and product.
std::vector<PedalNode> find_pedals();
/// Opens an input device for this program alone, so that its keys reach no other.
Result<InputFile> open_input(const std::string& node);

}  // namespace trephine::haptics
