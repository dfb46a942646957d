// The drivers of this library, by name.
#include <algorithm>
#include <charconv>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "haptics/device/device_kind.h"
#include "haptics/hardware/falcon_device.h"
#include "haptics/hardware/hid_link.h"
#include "haptics/hardware/input_file.h"
#include "haptics/hardware/pedal_device.h"
#include "haptics/hardware/spacemouse_device.h"
#include "haptics/hardware/usb_link.h"

namespace trephine::haptics {

namespace {

constexpr std::uint16_t k_ftdi = 0x0403, k_falcon = 0xcb48;
constexpr std::size_t k_largest_firmware = 1 << 20;  // bytes; the known image has about 20 kB
constexpr const char* k_rules_remedy =
    "install packaging/60-trephine.rules in /etc/udev/rules.d, then plug it in again";

Result<std::size_t> index_of(const std::string& selector, const std::string& kind) {
  if (selector.empty()) return std::size_t{0};
  std::size_t index = 0;
  const char* const end = selector.data() + selector.size();
  const auto [at, error] = std::from_chars(selector.data(), end, index);
  if (error != std::errc() || at != end || index > 99)
    return Error{.what = "the index of the device is invalid",
                 .where = "device",
                 .found = kind + ":" + selector,
                 .expected = kind + ", or " + kind + ":1 for the second one"};
  return index;
}

std::filesystem::path firmware_file(const DeviceHost& host) {
  return host.settings_folder.empty() ? std::filesystem::path()
                                      : std::filesystem::path(host.settings_folder) / "falcon.bin";
}

Result<std::vector<std::uint8_t>> read_firmware(const DeviceHost& host) {
  const std::filesystem::path file = firmware_file(host);
  std::ifstream in(file, std::ios::binary);
  if (!in)
    return Error{
        .what = "the Falcon has no firmware, and there is no file with one",
        .where = "falcon: firmware",
        .found = "",
        .expected = "falcon.bin in the settings folder of trephine",
        .remedy = "copy the firmware image of the device's own software to ~/.config/trephine/falcon.bin",
        .kind = ErrorKind::missing_here};
  std::vector<std::uint8_t> image{std::istreambuf_iterator<char>(in), {}};
  if (image.empty() || image.size() > k_largest_firmware)
    return Error{.what = "the firmware file of the Falcon has an impossible size",
                 .where = "falcon: firmware",
                 .found = std::to_string(image.size()) + " bytes",
                 .expected = "1 to 1048576 bytes",
                 .remedy = "copy the image of the device's own software again"};
  return image;
}

Result<std::shared_ptr<Device>> make_falcon(const std::string& selector, const DeviceHost& host) {
  const auto index = index_of(selector, "falcon");
  if (!index) return index.error();
  FalconChoice choice;
  choice.open_link = [i = index.value()] { return open_usb(k_ftdi, k_falcon, i, "falcon"); };
  choice.read_firmware = [host] { return read_firmware(host); };
  if (host.notice) choice.notice = host.notice;
  return std::shared_ptr<Device>(std::make_shared<FalconDevice>(std::move(choice)));
}

std::vector<DeviceCheck> check_falcon(const DeviceHost& host) {
  const auto found = find_usb(k_ftdi, k_falcon);
  if (!found) return {{found.error().what, found.error().remedy, true}};
  std::vector<DeviceCheck> checks;
  for (std::size_t i = 0; i < found.value().size(); ++i) {
    const UsbDevice& device = found.value()[i];
    checks.push_back({"Novint Falcon as 'falcon:" + std::to_string(i) + "', " + device.node() +
                          (device.is_accessible ? "" : ", which this user may not open"),
                      device.is_accessible ? "" : k_rules_remedy, !device.is_accessible, device.node()});
  }
  std::error_code error;
  if (!checks.empty() && !std::filesystem::exists(firmware_file(host), error))
    checks.push_back({"no firmware file of the Falcon, which is necessary after it was switched on",
                      "copy the image of the device's own software to ~/.config/trephine/falcon.bin", true});
  return checks;
}

Result<std::shared_ptr<Device>> make_spacemouse(const std::string& selector, const DeviceHost&) {
  const auto index = index_of(selector, "spacemouse");
  if (!index) return index.error();
  return std::shared_ptr<Device>(
      std::make_shared<SpaceMouseDevice>([i = index.value()] { return open_spacemouse(i); }));
}

std::vector<DeviceCheck> check_spacemice(const DeviceHost&) {
  const auto found = find_spacemice();
  if (!found) return {};  // a machine without HID devices has no fault
  std::vector<DeviceCheck> checks;
  for (std::size_t i = 0; i < found.value().size(); ++i) {
    const HidDevice& device = found.value()[i];
    checks.push_back({(device.product.empty() ? std::string("SpaceMouse") : device.product) +
                          " as 'spacemouse:" + std::to_string(i) + "', " + device.node +
                          (device.is_accessible ? "" : ", which this user may not open"),
                      device.is_accessible ? "" : k_rules_remedy, !device.is_accessible, device.node});
  }
  return checks;
}

Result<std::shared_ptr<Device>> make_pedal(const std::string& selector, const DeviceHost&) {
  if (selector.starts_with("/"))
    return std::shared_ptr<Device>(
        std::make_shared<PedalDevice>([selector] { return open_input(selector); }));
  const auto index = index_of(selector, "pedal");
  if (!index) return index.error();
  return std::shared_ptr<Device>(std::make_shared<PedalDevice>([i = index.value()]() -> Result<InputFile> {
    const std::vector<PedalNode> found = find_pedals();
    if (i < found.size()) return open_input(found[i].node);
    return Error{.what = "no foot pedal was found",
                 .where = "pedal: absent",
                 .found = std::to_string(found.size()),
                 .expected = "at least " + std::to_string(i + 1),
                 .remedy = "plug it in, or pass its file: pedal:/dev/input/event5",
                 .kind = ErrorKind::missing_here};
  }));
}

std::vector<DeviceCheck> check_pedals(const DeviceHost&) {
  std::vector<DeviceCheck> checks;
  const std::vector<PedalNode> found = find_pedals();
  for (std::size_t i = 0; i < found.size(); ++i)
    checks.push_back({found[i].name + " as 'pedal:" + std::to_string(i) + "', " + found[i].node +
                          (found[i].is_accessible ? "" : ", which this user may not open"),
                      found[i].is_accessible ? "" : k_rules_remedy, !found[i].is_accessible, found[i].node});
  return checks;
}

}  // namespace

}  // namespace trephine::haptics

/// Returns the kinds of devices that this library drives.
extern "C" __attribute__((visibility("default"))) const trephine::haptics::DeviceKind* trephine_device_kinds(
    std::size_t* count) {
  using namespace trephine::haptics;
  static const DeviceKind kinds[] = {
      {"falcon", "Novint Falcon: 3 degrees of freedom, 8 N", true, make_falcon, check_falcon},
      {"spacemouse", "3Dconnexion SpaceMouse: 6 degrees of freedom, no force", true, make_spacemouse,
       check_spacemice},
      {"pedal", "foot pedal: buttons and axes", false, make_pedal, check_pedals},
  };
  *count = std::size(kinds);
  return kinds;
}
