#include "haptics/hardware/usb_ids.h"

#include <algorithm>

namespace trephine::haptics {

namespace {

constexpr std::uint16_t k_falcon[] = {0xcb48};
/// 3-D mice that were sold under the name of Logitech. Other products of this vendor are ordinary mice and
/// keyboards, which no program should read directly.
constexpr std::uint16_t k_logitech_mice[] = {0xc603, 0xc605, 0xc606, 0xc621, 0xc623, 0xc625,
                                             0xc626, 0xc627, 0xc628, 0xc629, 0xc62b, 0xc640};
constexpr std::uint16_t k_transcription_pedal[] = {0x00ff};
constexpr std::uint16_t k_foot_switches[] = {0x7403, 0x7404};
constexpr std::uint16_t k_newer_foot_switches[] = {0xb001};

constexpr UsbIds k_ids[] = {
    {"Novint Falcon", "falcon", NodeKind::usb, 0x0403, k_falcon},
    {"Force Dimension omega, delta, sigma, lambda", "omega", NodeKind::usb, 0x1451, {}},
    {"3D Systems Touch", "touch", NodeKind::usb, 0x2988, {}},
    {"3D Systems Touch with a serial port", "touch", NodeKind::tty, 0x2988, {}},
    {"3D Systems Touch HID", "touch", NodeKind::hidraw, 0x2988, {}},
    {"3Dconnexion SpaceMouse", "spacemouse", NodeKind::hidraw, 0x256f, {}},
    {"3Dconnexion SpaceMouse of Logitech", "spacemouse", NodeKind::hidraw, 0x046d, k_logitech_mice},
    {"3Dconnexion SpaceMouse as a mouse", "spacemouse", NodeKind::input, 0x256f, {}},
    {"3Dconnexion SpaceMouse of Logitech as a mouse", "spacemouse", NodeKind::input, 0x046d, k_logitech_mice},
    {"PCsensor foot switch", "pedal", NodeKind::input, 0x0c45, k_foot_switches},
    {"PCsensor foot switch, newer", "pedal", NodeKind::input, 0x3553, k_newer_foot_switches},
    {"Infinity transcription pedal", "pedal", NodeKind::hidraw, 0x05f3, k_transcription_pedal},
};

}  // namespace

std::span<const UsbIds> usb_ids() noexcept { return k_ids; }

const UsbIds& usb_ids_of(std::string_view device) noexcept {
  return *std::find_if(std::begin(k_ids), std::end(k_ids),
                       [&](const UsbIds& ids) { return ids.device == device; });
}

std::string hex_of(std::uint16_t id) {
  std::string text(4, '0');
  for (std::size_t digit = 4; digit > 0; id = static_cast<std::uint16_t>(id >> 4))
    text[--digit] = "0123456789abcdef"[id & 15];
  return text;
}

std::string udev_rules() {
  std::string rules =
      "# Haptic devices, 3-D mice and pedals: access for the user of this computer.\n"
      "# After a change: udevadm control --reload && udevadm trigger\n";
  for (const UsbIds& ids : k_ids) {
    // A USB device has ATTR; ports, HID and input devices have a USB device among their parents.
    std::string attribute = "ATTRS";
    rules.append("\n# ").append(ids.name).append("\n");
    switch (ids.node) {
      case NodeKind::usb:
        rules += "SUBSYSTEM==\"usb\"";
        attribute = "ATTR";
        break;
      case NodeKind::tty:
        rules += "SUBSYSTEM==\"tty\", KERNEL==\"ttyACM*\"";
        break;
      case NodeKind::hidraw:
        rules += "SUBSYSTEM==\"hidraw\"";
        break;
      case NodeKind::input:
        rules += "SUBSYSTEM==\"input\", KERNEL==\"event*\"";
        break;
    }
    const auto add_condition = [&](const char* id, const std::string& values) {
      rules.append(", ").append(attribute).append("{").append(id).append("}==\"").append(values).append("\"");
    };
    add_condition("idVendor", hex_of(ids.vendor));
    std::string products;
    for (const std::uint16_t product : ids.products)
      products.append(products.empty() ? "" : "|").append(hex_of(product));
    if (!products.empty()) add_condition("idProduct", products);
    rules += ", TAG+=\"uaccess\"\n";
  }
  return rules;
}

}  // namespace trephine::haptics
