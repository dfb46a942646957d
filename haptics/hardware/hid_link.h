// Access to HID devices with the library hidapi.
#pragma once

#include <string>
#include <vector>

#include "haptics/hardware/links.h"

namespace trephine::haptics {

/// A SpaceMouse that is connected to this computer.
struct HidDevice {
  std::string node, product;  ///< file, such as /dev/hidraw0; name that the device reports
  std::uint16_t vendor_id = 0, product_id = 0;
  bool is_accessible = false;  ///< this user may open the file
};

/// Returns the connected 3-D mice: devices of 3Dconnexion and Logitech that report the HID usage of a
/// multi-axis controller.
Result<std::vector<HidDevice>> find_spacemice();
/// Opens a 3-D mouse by its index in the result of find_spacemice().
Result<std::unique_ptr<HidLink>> open_spacemouse(std::size_t index);

}  // namespace trephine::haptics
