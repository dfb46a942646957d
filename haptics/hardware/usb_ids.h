// USB ids of the supported devices. The drivers, the udev rules and docs/devices.md use this table.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>

namespace trephine::haptics {

/// Subsystem of the file in /dev by which a program opens a device.
enum class NodeKind : std::uint8_t { usb, tty, hidraw, input };

/// Devices of one vendor that are opened in the same way.
struct UsbIds {
  std::string_view name;    ///< of the devices, for people
  std::string_view device;  ///< name of the driver: "falcon"
  NodeKind node;
  std::uint16_t vendor;
  std::span<const std::uint16_t> products;  ///< empty: all products of the vendor
};

std::span<const UsbIds> usb_ids() noexcept;
/// Returns the first entry of a driver. `device` must be in the table.
const UsbIds& usb_ids_of(std::string_view device) noexcept;
/// Returns an id as udev and sysfs write it: four hexadecimal digits.
std::string hex_of(std::uint16_t id);
/// Returns the udev rules that allow the user of this computer to open the devices: the contents of
/// packaging/60-trephine.rules.
std::string udev_rules();

}  // namespace trephine::haptics
