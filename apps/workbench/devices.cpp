#include "apps/workbench/devices.h"

#include <algorithm>
#include <cstdlib>
#include <dlfcn.h>
#include <utility>

#include "apps/workbench/source.h"
#include "data-tools/cases/device_file.h"
#include "haptics/device/composite_device.h"
#include "haptics/device/mapped_device.h"

namespace trephine::workbench {

using DevicePointer = std::shared_ptr<haptics::Device>;

namespace {

/// A device's name, split at its first colon.
struct DeviceName {
  std::string kind, selector;
  bool has_selector = false;

  explicit DeviceName(const std::string& name) {
    const std::size_t colon = name.find(':');
    kind = name.substr(0, colon);
    has_selector = colon != std::string::npos;
    if (has_selector) selector = name.substr(colon + 1);
  }
  /// Returns the name with its number written out: "falcon" and "falcon:00" are "falcon:0".
  std::string full() const {
    const bool is_number = selector.find_first_not_of("0123456789") == std::string::npos;
    if (!is_number) return kind + ":" + selector;
    const std::size_t digit = std::min(selector.find_first_not_of('0'), selector.size());
    return kind + ":" + (digit == selector.size() ? "0" : selector.substr(digit));
  }
};

Result<DevicePointer> open_path_device(const DeviceName& name) {
  if (name.selector.empty())
    return Error{.what = "the device needs a path",
                 .where = "device",
                 .found = name.kind,
                 .expected = name.kind + ":PATH.csv",
                 .remedy = "add a colon and the name of a CSV file"};
  Result<haptics::PosePath> path = open_path(name.selector);
  if (!path) return path.error();
  if (name.kind == "virtual")
    return DevicePointer(
        std::make_shared<haptics::VirtualDevice>(std::move(path).value(), haptics::HandModel()));
  return DevicePointer(std::make_shared<haptics::PlaybackDevice>(std::move(path).value()));
}

/// Creates the driver of a device; its poses are in the frame of the device.
Result<DevicePointer> make_hardware(const std::string& text, bool has_pose, const Listener& listener) {
  const DeviceName name(text);
  const auto kinds = hardware_kinds();
  std::string known =
      has_pose ? "mouse, playback:PATH.csv, virtual:PATH.csv" : "pedal:/dev/input/event5, pedal:/dev/hidraw3";
  if (kinds)
    for (const haptics::DeviceKind& kind : kinds.value()) {
      if (kind.has_pose != has_pose) continue;
      known += (known.empty() ? "" : ", ") + kind.name;
      if (kind.name != name.kind) continue;
      if (name.has_selector && name.selector.empty())
        return Error{.what = "the device has no selector after its colon",
                     .where = "device",
                     .found = text,
                     .expected = kind.name + ", or " + kind.name + (kind.name == "touch" ? ":NAME" : ":1"),
                     .remedy = "add the selector, or remove the colon"};
      return kind.make(name.selector, device_host(listener));
    }
  else
    for (const char* const kind : {"falcon", "touch", "omega", "inverse3", "spacemouse", "remote", "pedal"})
      if (name.kind == kind) return kinds.error();
  return Error{.what = has_pose ? "unknown device" : "unknown pedal",
               .where = "device",
               .found = text,
               .expected = known,
               .remedy = "choose one of these; 'trephine doctor --devices' lists the connected devices"};
}

}  // namespace

Result<std::span<const haptics::DeviceKind>> hardware_kinds() {
  void* const library = ::dlopen(TREPHINE_DEVICES_LIBRARY, RTLD_NOW | RTLD_LOCAL);
  void* const entry = library ? ::dlsym(library, "trephine_device_kinds") : nullptr;
  if (entry) {
    std::size_t count = 0;
    const haptics::DeviceKind* const first = reinterpret_cast<haptics::DeviceKindsFunction>(entry)(&count);
    return std::span(first, count);
  }
  return Error{.what = "the library of device drivers is not installed",
               .where = "device",
               .expected = TREPHINE_DEVICES_LIBRARY,
               .remedy = "install the package trephine-devices, or build with TREPHINE_WITH_DEVICES=ON",
               .kind = ErrorKind::missing_here};
}

haptics::DeviceHost device_host(const Listener& listener) {
  haptics::DeviceHost host;
  host.notice = listener.notice;
  host.should_stop = listener.should_stop;
  const char* const settings = std::getenv("XDG_CONFIG_HOME");
  const char* const home = std::getenv("HOME");
  if (settings && *settings == '/')
    host.settings_folder = std::string(settings) + "/trephine";
  else if (home && *home == '/')
    host.settings_folder = std::string(home) + "/.config/trephine";
  return host;
}

namespace {

/// Completes a choice without a device by the user's devices.toml, or else by the mouse.
Result<DeviceChoice> completed(DeviceChoice choice, const Listener& listener) {
  if (!choice.device.empty()) return choice;
  choice.device = "mouse";
  const std::string folder = device_host(listener).settings_folder;
  if (folder.empty()) return choice;
  const auto settings = data_tools::read_device_settings(folder + "/devices.toml");
  if (!settings) return settings.error();
  if (!settings.value()) return choice;
  if (!settings.value()->device.empty()) choice.device = settings.value()->device;
  if (choice.pedal.empty()) choice.pedal = settings.value()->pedal;
  if (choice.scale == 1 && choice.device != "mouse") choice.scale = settings.value()->scale;
  if (choice.device != "mouse" || !choice.pedal.empty())
    listener.notice("note: devices.toml selects " + choice.device +
                    (choice.pedal.empty() ? "" : " and " + choice.pedal) + " (override it with --device)");
  return choice;
}

}  // namespace

namespace {

/// Creates a device that is not the mouse. `pedal`: its buttons are added; may be null.
Result<DevicePointer> make_device(const std::string& text, double scale, DevicePointer pedal,
                                  const Listener& listener) {
  const DeviceName name(text);
  const bool is_path = name.kind == "playback" || name.kind == "virtual";
  haptics::WorkspaceMap map;
  map.scale = scale;
  if (Status error = haptics::check(map)) return *error;
  auto device = is_path ? open_path_device(name) : make_hardware(text, true, listener);
  if (!device) return device;
  // Add the pedal before the map, because the second button of the pedal also acts as the clutch of the map.
  DevicePointer made = std::move(device).value();
  if (pedal) made = std::make_shared<haptics::CompositeDevice>(std::move(made), std::move(pedal));
  if (!is_path) made = std::make_shared<haptics::MappedDevice>(std::move(made), map);
  return made;
}

}  // namespace

Result<ChosenDevices> make_devices(const DeviceChoice& requested, const Listener& listener) {
  const auto completed_choice = completed(requested, listener);
  if (!completed_choice) return completed_choice.error();
  const DeviceChoice& choice = completed_choice.value();
  ChosenDevices chosen;
  // Returns the error with the option, or the file, that names the device.
  const bool is_of_file = requested.device.empty() && choice.device != "mouse";
  const auto at = [](Error error, const char* option) {
    if (error.where == "device") error.where = option;
    return error;
  };
  if (!choice.pedal.empty()) {
    auto pedal = make_hardware(choice.pedal, false, listener);
    if (!pedal) return at(pedal.error(), requested.pedal.empty() ? "devices.toml" : "pedal");
    chosen.pedal = std::move(pedal).value();
  }
  const DeviceName name(choice.device);
  const bool is_path = name.kind == "playback" || name.kind == "virtual";
  const bool is_mouse = choice.device == "mouse";
  if ((is_mouse || is_path) && choice.scale != 1)
    return Error{.what = "only hardware has a scale",
                 .where = "device scale",
                 .found = name.kind,
                 .remedy = "omit the scale, or choose another device"};
  if (choice.left == "mouse")
    return Error{.what = "the mouse can drive the right hand only",
                 .where = "left",
                 .found = "mouse",
                 .expected = "a haptic device, a 3-D mouse, playback:PATH.csv or virtual:PATH.csv",
                 .remedy = "choose another device for the left hand"};
  const DeviceName left_name(choice.left);
  if (left_name.kind == "touch" && name.kind == "touch")
    return Error{.what = "only one hand can have a Touch",
                 .where = "left",
                 .found = choice.left,
                 .expected = "a device of another kind",
                 .remedy = "choose another device for one hand"};
  if (!choice.left.empty() && left_name.full() == name.full() && !is_path)
    return Error{.what = "both hands have the same device",
                 .where = "left",
                 .found = choice.left,
                 .expected = "two devices, such as falcon and falcon:1",
                 .remedy = "choose another device for one hand"};
  if (!choice.left.empty()) {
    // The scale is that of hardware; a path is followed as it is.
    auto left = make_device(choice.left, choice.scale, nullptr, listener);
    if (!left) return at(left.error(), "left");
    chosen.left = std::move(left).value();
  }
  if (is_mouse) return chosen;
  auto device = make_device(choice.device, choice.scale, std::exchange(chosen.pedal, {}), listener);
  if (!device) return at(device.error(), is_of_file ? "devices.toml" : "device");
  chosen.device = std::move(device).value();
  return chosen;
}

std::vector<haptics::DeviceCapabilities> capabilities_of(const ChosenDevices& chosen) {
  std::vector<haptics::DeviceCapabilities> all;
  for (const DevicePointer& device : {chosen.device, chosen.left})
    if (device) all.push_back(device->capabilities());
  return all;
}

Status try_devices(const ChosenDevices& chosen) {
  for (const DevicePointer& device : {chosen.device, chosen.left, chosen.pedal}) {
    if (!device) continue;
    if (Status error = device->open()) return error;
    device->close();
  }
  return std::nullopt;
}

}  // namespace trephine::workbench
