#include "haptics/hardware/hid_link.h"

#include <algorithm>
#include <cerrno>
#include <filesystem>
#include <hidapi/hidapi.h>
#include <unistd.h>

#include "haptics/hardware/input_file.h"
#include "haptics/hardware/usb_ids.h"

namespace trephine::haptics {

namespace {

constexpr std::uint16_t k_generic_desktop = 1, k_multi_axis = 8;

std::string narrow(const wchar_t* text) {
  std::string result;
  for (; text != nullptr && *text != 0; ++text)
    result += *text >= 32 && *text < 127 ? static_cast<char>(*text) : '?';
  return result;
}

class HidapiLink final : public HidLink {
 public:
  /// `node`: the device's file, such as /dev/hidraw0. The kernel also reports this device as a mouse, whose
  /// motions would move the cursor while the device moves a tool.
  HidapiLink(hid_device* device, const std::string& node)
      : device_(device),
        grab_(event_files_of("/sys/class/hidraw/" + std::filesystem::path(node).filename().string() +
                             "/device")) {}
  ~HidapiLink() override { hid_close(device_); }
  LinkResult write(std::span<const std::uint8_t> report) noexcept override {
    return hid_write(device_, report.data(), report.size()) < 0 ? LinkResult::failed : LinkResult::done;
  }
  LinkResult read(std::span<std::uint8_t> report, std::size_t& count, int timeout_ms) noexcept override {
    const int read = hid_read_timeout(device_, report.data(), report.size(), timeout_ms);
    count = read > 0 ? static_cast<std::size_t>(read) : 0;
    if (read < 0) return errno == EINTR ? LinkResult::timed_out : LinkResult::disconnected;
    return read == 0 ? LinkResult::timed_out : LinkResult::done;
  }

 private:
  hid_device* device_;
  InputGrab grab_;
};

}  // namespace

Result<std::vector<HidDevice>> find_spacemice() {
  if (hid_init() != 0)
    return Error{.what = "HID devices are not available",
                 .where = "hid: service",
                 .remedy = "check that /dev/hidraw0 exists",
                 .kind = ErrorKind::missing_here};
  std::vector<HidDevice> found;
  for (const UsbIds& ids : usb_ids()) {
    if (ids.device != "spacemouse" || ids.node != NodeKind::hidraw) continue;
    hid_device_info* const list = hid_enumerate(ids.vendor, 0);
    for (const hid_device_info* info = list; info != nullptr; info = info->next) {
      if (info->usage_page != k_generic_desktop || info->usage != k_multi_axis) continue;
      HidDevice device{.node = info->path,
                       .product = narrow(info->product_string),
                       .vendor_id = info->vendor_id,
                       .product_id = info->product_id};
      device.is_accessible = ::access(info->path, R_OK | W_OK) == 0;
      found.push_back(std::move(device));
    }
    hid_free_enumeration(list);
  }
  std::sort(found.begin(), found.end(), [](const auto& a, const auto& b) { return a.node < b.node; });
  return found;
}

Result<std::unique_ptr<HidLink>> open_spacemouse(std::size_t index) {
  const auto found = find_spacemice();
  if (!found) return found.error();
  if (index >= found.value().size())
    return Error{.what = "the SpaceMouse was not found",
                 .where = "spacemouse: absent",
                 .found = std::to_string(found.value().size()),
                 .expected = "at least " + std::to_string(index + 1),
                 .remedy = "plug it in, or pair its receiver",
                 .kind = ErrorKind::missing_here};
  const HidDevice& device = found.value()[index];
  hid_device* const opened = hid_open_path(device.node.c_str());
  if (opened == nullptr)
    return Error{
        .what = device.is_accessible ? "another program uses the SpaceMouse"
                                     : "this user may not open the SpaceMouse",
        .where = device.is_accessible ? "spacemouse: busy" : "spacemouse: permission",
        .found = device.node,
        .remedy = device.is_accessible
                      ? "stop spacenavd, or close the other program"
                      : "install packaging/60-trephine.rules in /etc/udev/rules.d, then plug it in again",
        .kind = ErrorKind::missing_here};
  return std::unique_ptr<HidLink>(std::make_unique<HidapiLink>(opened, device.node));
}

}  // namespace trephine::haptics
