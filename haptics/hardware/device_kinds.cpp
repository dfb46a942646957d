// The drivers of this library, by name.
#include <algorithm>
#include <charconv>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <unistd.h>

#include "haptics/device/device_kind.h"
#include "haptics/device/shared_device.h"
#include "haptics/hardware/falcon_device.h"
#include "haptics/hardware/force_dimension_device.h"
#include "haptics/hardware/hid_link.h"
#include "haptics/hardware/input_file.h"
#include "haptics/hardware/inverse3_device.h"
#include "haptics/hardware/pedal_device.h"
#include "haptics/hardware/spacemouse_device.h"
#include "haptics/hardware/touch_device.h"
#include "haptics/hardware/usb_link.h"

namespace trephine::haptics {

namespace {

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
                 .expected = kind + ", or " + kind + ":1 for the second one" +
                             (kind == "pedal" ? ", or a file: pedal:/dev/input/event5" : ""),
                 .remedy = "'trephine doctor --devices' lists the connected devices"};
  return index;
}

std::filesystem::path firmware_file(const DeviceHost& host) {
  return host.settings_folder.empty() ? std::filesystem::path()
                                      : std::filesystem::path(host.settings_folder) / "falcon.bin";
}

Result<std::vector<std::uint8_t>> read_firmware(const DeviceHost& host) {
  const std::filesystem::path file = firmware_file(host);
  std::error_code error;
  const bool is_file = std::filesystem::is_regular_file(file, error);
  std::ifstream in;
  if (is_file) in.open(file, std::ios::binary);
  if (!is_file || !in)
    return Error{
        .what = "the Falcon has no firmware, and its firmware file is missing",
        .where = "falcon: firmware",
        .found = "",
        .expected = "falcon.bin in the settings folder of trephine",
        .remedy =
            "copy the firmware image of the device's own software to $XDG_CONFIG_HOME/trephine/falcon.bin "
            "(~/.config/trephine/falcon.bin if the variable is not set)",
        .kind = ErrorKind::missing_here};
  std::vector<std::uint8_t> image(k_largest_firmware + 1);
  in.read(reinterpret_cast<char*>(image.data()), static_cast<std::streamsize>(image.size()));
  image.resize(static_cast<std::size_t>(in.gcount()));
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
  choice.open_link = [i = index.value()] { return open_usb(usb_ids_of("falcon"), i); };
  choice.read_firmware = [host] { return read_firmware(host); };
  if (host.notice) choice.notice = host.notice;
  choice.should_stop = host.should_stop;
  return std::shared_ptr<Device>(std::make_shared<FalconDevice>(std::move(choice)));
}

/// Returns the check of a device that was found: its name, its file, and whether this user may open it.
DeviceCheck check_node(const std::string& product, const std::string& name, const std::string& node,
                       bool is_accessible) {
  return {product + " as '" + name + "', " + node + (is_accessible ? "" : ", which this user may not open"),
          is_accessible ? "" : k_rules_remedy, !is_accessible, node};
}

/// Checks the connected devices of a driver. `label`: name of such a device.
std::vector<DeviceCheck> check_usb(const std::string& kind, const std::string& label) {
  const auto found = find_usb(usb_ids_of(kind));
  if (!found) return {{found.error().what, found.error().remedy, true}};
  std::vector<DeviceCheck> checks;
  for (std::size_t i = 0; i < found.value().size(); ++i) {
    const UsbDevice& device = found.value()[i];
    checks.push_back(check_node(label, kind + ":" + std::to_string(i), device.node(), device.is_accessible));
  }
  return checks;
}

/// Adds the result of loading a vendor's library. Call only if a device is plugged in.
void add_library_check(std::vector<DeviceCheck>& checks, const Status& error, const std::string& product) {
  if (error)
    checks.push_back({error->what + (error->found.empty() ? "" : ": " + error->found), error->remedy, true});
  else
    checks.push_back({"the library of " + product + " is installed"});
}

std::vector<DeviceCheck> check_falcon(const DeviceHost& host) {
  std::vector<DeviceCheck> checks = check_usb("falcon", "Novint Falcon");
  if (!checks.empty() && checks.front().node.empty()) return checks;
  std::error_code error;
  if (!checks.empty() && !std::filesystem::exists(firmware_file(host), error))
    checks.push_back({"no firmware file for the Falcon, which loses its firmware when it is switched off",
                      "copy the image of the device's own software to $XDG_CONFIG_HOME/trephine/falcon.bin "
                      "(~/.config/trephine/falcon.bin if the variable is not set)",
                      true});
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
    checks.push_back(check_node(device.product.empty() ? "SpaceMouse" : device.product,
                                "spacemouse:" + std::to_string(i), device.node, device.is_accessible));
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
    return Error{.what = "the foot pedal was not found",
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
    checks.push_back(
        check_node(found[i].name, "pedal:" + std::to_string(i), found[i].node, found[i].is_accessible));
  return checks;
}

Result<std::shared_ptr<Device>> make_touch(const std::string& selector, const DeviceHost& host) {
  TouchChoice choice;
  choice.name = selector;
  if (host.notice) choice.notice = host.notice;
  choice.should_stop = host.should_stop;
  return std::shared_ptr<Device>(std::make_shared<TouchDevice>(std::move(choice)));
}

/// Returns the device files of serial ports of 3D Systems: some models are used through such a port.
std::vector<std::string> find_touch_ports() {
  std::vector<std::string> ports;
  std::error_code error;
  for (std::filesystem::directory_iterator it("/sys/class/tty", error), end; !error && it != end;
       it.increment(error)) {
    const std::string name = it->path().filename();
    if (!name.starts_with("ttyACM")) continue;
    std::string vendor;
    std::ifstream(it->path() / "device" / ".." / "idVendor") >> vendor;
    if (vendor == hex_of(usb_ids_of("touch").vendor)) ports.push_back("/dev/" + name);
  }
  return ports;
}

std::vector<DeviceCheck> check_touch(const DeviceHost&) {
  const auto found = find_usb(usb_ids_of("touch"));
  if (!found || found.value().empty()) return {};
  std::vector<DeviceCheck> checks;
  for (const std::string& port : find_touch_ports())
    checks.push_back(check_node("3D Systems Touch", "touch", port, ::access(port.c_str(), R_OK | W_OK) == 0));
  if (checks.empty())
    for (const UsbDevice& device : found.value())
      checks.push_back(check_node("3D Systems Touch", "touch", device.node(), device.is_accessible));
  add_library_check(checks, check_touch_library(), "OpenHaptics");
  return checks;
}

Result<std::shared_ptr<Device>> make_force_dimension(const std::string& selector, const DeviceHost&) {
  const auto index = index_of(selector, "omega");
  if (!index) return index.error();
  return std::shared_ptr<Device>(
      std::make_shared<ForceDimensionDevice>(ForceDimensionChoice{index.value(), dhd_files()}));
}

std::vector<DeviceCheck> check_force_dimension(const DeviceHost&) {
  std::vector<DeviceCheck> checks = check_usb("omega", "Force Dimension device");
  if (!checks.empty() && !checks.front().node.empty())
    add_library_check(checks, check_dhd_library(), "Force Dimension");
  return checks;
}

Result<std::shared_ptr<Device>> make_inverse3(const std::string& selector, const DeviceHost&) {
  const auto index = index_of(selector, "inverse3");
  if (!index) return index.error();
  return std::shared_ptr<Device>(std::make_shared<Inverse3Device>(Inverse3Choice{.index = index.value()}));
}

std::vector<DeviceCheck> check_inverse3(const DeviceHost&) {
  const auto count = count_inverse3(Inverse3Choice().port);
  if (!count) return {};  // the service of Haply does not run: not a fault on a machine without its devices
  if (count.value() == 0)
    return {{"the service of Haply reports no Inverse3", "plug it in and switch it on", false}};
  std::vector<DeviceCheck> checks;
  for (std::size_t i = 0; i < count.value(); ++i)
    checks.push_back({"Haply Inverse3 as 'inverse3:" + std::to_string(i) + "'"});
  return checks;
}

Result<std::shared_ptr<Device>> make_remote(const std::string& selector, const DeviceHost&) {
  const auto index = index_of(selector, "remote");
  if (!index) return index.error();
  return std::shared_ptr<Device>(std::make_shared<SharedDevice>(static_cast<int>(index.value())));
}

std::vector<DeviceCheck> check_remote(const DeviceHost&) {
  std::vector<DeviceCheck> checks;
  for (int i = 0; i <= SharedDeviceMemory::k_max_index; ++i)
    if (SharedDeviceMemory::exists(i))
      checks.push_back({"virtual device of another program as 'remote:" + std::to_string(i) + "'"});
  return checks;
}

std::string nothing_missing(const DeviceHost&) { return {}; }

std::string missing_for_falcon(const DeviceHost& host) {
  std::error_code error;
  return std::filesystem::is_regular_file(firmware_file(host), error)
             ? ""
             : "its firmware file falcon.bin is missing";
}
std::string missing_for_touch(const DeviceHost&) {
  return check_touch_library() ? "OpenHaptics is not installed" : "";
}
std::string missing_for_omega(const DeviceHost&) {
  return check_dhd_library() ? "the SDK of Force Dimension is not installed" : "";
}
std::string missing_for_inverse3(const DeviceHost&) {
  return count_inverse3(Inverse3Choice().port) ? "" : "the Haply Inverse Service does not run";
}

}  // namespace

}  // namespace trephine::haptics

/// Returns the kinds of devices that this library drives.
extern "C" __attribute__((visibility("default"))) const trephine::haptics::DeviceKind* trephine_device_kinds(
    std::size_t* count) {
  using namespace trephine::haptics;
  static const DeviceKind kinds[] = {
      {"falcon", "Novint Falcon: 3 degrees of freedom, 8 N", true, make_falcon, check_falcon,
       missing_for_falcon},
      {"touch", "3D Systems Touch, Omni, Phantom: 6 degrees of freedom, with OpenHaptics", true, make_touch,
       check_touch, missing_for_touch},
      {"omega", "Force Dimension omega, delta, sigma, lambda: 3 or 6 degrees of freedom, with its SDK", true,
       make_force_dimension, check_force_dimension, missing_for_omega},
      {"inverse3", "Haply Inverse3: 6 degrees of freedom, 8 N, with its service", true, make_inverse3,
       check_inverse3, missing_for_inverse3},
      {"spacemouse", "3Dconnexion SpaceMouse: 6 degrees of freedom, no force", true, make_spacemouse,
       check_spacemice, nothing_missing},
      {"remote", "virtual device of another program, such as trephine virtual-device: 6 degrees of freedom",
       true, make_remote, check_remote, nothing_missing},
      {"pedal", "foot pedal: buttons and axes", false, make_pedal, check_pedals, nothing_missing},
  };
  *count = std::size(kinds);
  return kinds;
}
