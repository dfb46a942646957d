// HID devices by hidapi.
#pragma once

#include <string>
#include <vector>

#include "haptics/hardware/links.h"

namespace trephine::haptics {

/// A SpaceMouse on the bus.
struct HidDevice {
  std::string node, product;  ///< /dev/hidraw0; the name that the device reports
  std::uint16_t vendor_id = 0, product_id = 0;
  bool is_accessible = false;
};

/// Returns the 3-D mice: devices of 3Dconnexion and Logitech with the usage of a multi-axis controller.
Result<std::vector<HidDevice>> find_spacemice();
/// Opens the 3-D mouse with an index among those found.
Result<std::unique_ptr<HidLink>> open_spacemouse(std::size_t index);

}  // namespace trephine::haptics
