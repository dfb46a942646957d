// Access to USB devices with the library libusb.
#pragma once

#include <string>
#include <vector>

#include "haptics/hardware/links.h"
#include "haptics/hardware/usb_ids.h"

namespace trephine::haptics {

/// A device on the bus.
struct UsbDevice {
  int bus = 0, address = 0;
  bool is_accessible = false;  ///< this user may open it
  std::string node() const;    ///< file of the device, /dev/bus/usb/...
};

/// Returns the connected devices of an entry, in the order in which libusb lists them.
Result<std::vector<UsbDevice>> find_usb(const UsbIds& ids);
/// Opens a device by its index in the result of find_usb(). If a driver of the kernel uses the device, the
/// driver is detached until the link is closed.
Result<std::unique_ptr<UsbLink>> open_usb(const UsbIds& ids, std::size_t index);

}  // namespace trephine::haptics
