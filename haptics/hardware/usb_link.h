// Access to USB devices with the library libusb.
#pragma once

#include <string>
#include <vector>

#include "haptics/hardware/links.h"

namespace trephine::haptics {

/// A device on the bus.
struct UsbDevice {
  int bus = 0, address = 0;
  bool is_accessible = false;  ///< this user may open it
  std::string node() const;    ///< file of the device, /dev/bus/usb/...
};

/// Returns the devices of a vendor and product, in the order in which libusb lists them. `product` 0: all
/// products of the vendor.
Result<std::vector<UsbDevice>> find_usb(std::uint16_t vendor, std::uint16_t product);
/// Opens a device by its index among the devices of a vendor and product. `name`: name of the device, for
/// errors. If a driver of the kernel uses the device, the driver is detached until the link is closed.
Result<std::unique_ptr<UsbLink>> open_usb(std::uint16_t vendor, std::uint16_t product, std::size_t index,
                                          const std::string& name);

}  // namespace trephine::haptics
