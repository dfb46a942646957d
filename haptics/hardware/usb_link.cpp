#include "haptics/hardware/usb_link.h"

#include <algorithm>
#include <cstdio>
#include <libusb.h>
#include <unistd.h>

namespace trephine::haptics {

namespace {

constexpr unsigned char k_endpoint_out = 0x02, k_endpoint_in = 0x81;
constexpr std::uint8_t k_vendor_request = 0x40;
constexpr int k_control_ms = 1000;

struct Context {
  libusb_context* usb = nullptr;
  int error = libusb_init(&usb);
  Context() = default;
  Context(const Context&) = delete;
  Context& operator=(const Context&) = delete;
  ~Context() {
    if (error == 0) libusb_exit(usb);
  }
};

bool matches(const UsbIds& ids, const libusb_device_descriptor& device) {
  return device.idVendor == ids.vendor &&
         (ids.products.empty() ||
          std::find(ids.products.begin(), ids.products.end(), device.idProduct) != ids.products.end());
}

/// Calls each(device) for the devices of an entry, until it returns false. Returns 0, or the code of an
/// error.
template <class Each>
int for_devices(libusb_context* context, const UsbIds& ids, const Each& each) {
  libusb_device** list = nullptr;
  const ssize_t count = libusb_get_device_list(context, &list);
  if (count < 0) return static_cast<int>(count);
  for (ssize_t i = 0; i < count; ++i) {
    libusb_device_descriptor descriptor{};
    if (libusb_get_device_descriptor(list[i], &descriptor) != 0) continue;
    if (matches(ids, descriptor) && !each(list[i])) break;
  }
  libusb_free_device_list(list, 1);
  return 0;
}

UsbDevice describe(libusb_device* device) {
  UsbDevice result{.bus = libusb_get_bus_number(device), .address = libusb_get_device_address(device)};
  result.is_accessible = ::access(result.node().c_str(), R_OK | W_OK) == 0;
  return result;
}

Error no_libusb(int code) {
  return {.what = "USB is not available",
          .where = "usb: service",
          .found = libusb_error_name(code),
          .remedy = "check that /dev/bus/usb exists",
          .kind = ErrorKind::missing_here};
}

class LibusbLink final : public UsbLink {
 public:
  LibusbLink(std::unique_ptr<Context> context, libusb_device_handle* handle)
      : context_(std::move(context)), handle_(handle) {}
  ~LibusbLink() override {
    libusb_release_interface(handle_, 0);
    libusb_close(handle_);
  }
  LinkResult control(std::uint8_t request, std::uint16_t value) noexcept override {
    return result_of(
        libusb_control_transfer(handle_, k_vendor_request, request, value, 0, nullptr, 0, k_control_ms));
  }
  LinkResult write(std::span<const std::uint8_t> bytes, int timeout_ms) noexcept override {
    int sent = 0;
    // libusb does not change bytes that are sent.
    auto* data = const_cast<unsigned char*>(bytes.data());
    const int code = libusb_bulk_transfer(handle_, k_endpoint_out, data, static_cast<int>(bytes.size()),
                                          &sent, static_cast<unsigned>(timeout_ms));
    if (code == 0 && sent != static_cast<int>(bytes.size())) return LinkResult::failed;
    return result_of(code);
  }
  LinkResult read(std::span<std::uint8_t> buffer, std::size_t& count, int timeout_ms) noexcept override {
    int received = 0;
    const int code =
        libusb_bulk_transfer(handle_, k_endpoint_in, buffer.data(), static_cast<int>(buffer.size()),
                             &received, static_cast<unsigned>(timeout_ms));
    count = static_cast<std::size_t>(received);
    return result_of(code);
  }

 private:
  static LinkResult result_of(int code) noexcept {
    if (code >= 0) return LinkResult::done;
    if (code == LIBUSB_ERROR_TIMEOUT) return LinkResult::timed_out;
    if (code == LIBUSB_ERROR_NO_DEVICE || code == LIBUSB_ERROR_IO) return LinkResult::disconnected;
    return LinkResult::failed;
  }

  std::unique_ptr<Context> context_;
  libusb_device_handle* handle_;
};

}  // namespace

std::string UsbDevice::node() const {
  char text[64];
  std::snprintf(text, sizeof(text), "/dev/bus/usb/%03d/%03d", bus, address);
  return text;
}

Result<std::vector<UsbDevice>> find_usb(const UsbIds& ids) {
  const Context context;
  if (context.error != 0) return no_libusb(context.error);
  std::vector<UsbDevice> found;
  const int code = for_devices(context.usb, ids, [&](libusb_device* device) {
    found.push_back(describe(device));
    return true;
  });
  if (code < 0) return no_libusb(code);
  return found;
}

Result<std::unique_ptr<UsbLink>> open_usb(const UsbIds& ids, std::size_t index) {
  const std::string name(ids.device);
  auto context = std::make_unique<Context>();
  if (context->error != 0) return no_libusb(context->error);
  libusb_device_handle* handle = nullptr;
  int code = LIBUSB_ERROR_NO_DEVICE;
  std::size_t at = 0;
  std::string node;
  for_devices(context->usb, ids, [&](libusb_device* device) {
    if (at++ != index) return true;
    node = describe(device).node();
    code = libusb_open(device, &handle);
    return false;
  });
  if (node.empty())
    return Error{
        .what = at == 0 ? "the device was not found on the USB" : "no device of this kind has this index",
        .where = name + ": absent",
        .found = "connected devices: " + std::to_string(at),
        .expected = "at least " + std::to_string(index + 1),
        .remedy = "plug it in, and switch its power on",
        .kind = ErrorKind::missing_here};
  if (code == LIBUSB_ERROR_ACCESS)
    return Error{
        .what = "this user may not open the device",
        .where = name + ": permission",
        .found = node,
        .remedy = "install packaging/60-trephine.rules in /etc/udev/rules.d, then plug the device in again",
        .kind = ErrorKind::missing_here};
  if (code == 0) {
    // By default, the kernel's serial driver claims the device's FTDI converter.
    libusb_set_auto_detach_kernel_driver(handle, 1);
    code = libusb_claim_interface(handle, 0);
    if (code != 0) libusb_close(handle);
  }
  if (code == LIBUSB_ERROR_BUSY)
    return Error{.what = "another program or driver uses the device",
                 .where = name + ": busy",
                 .found = node,
                 .remedy = "close the other program; 'trephine doctor --devices' names it",
                 .kind = ErrorKind::missing_here};
  if (code != 0)
    return Error{.what = "the device could not be opened",
                 .where = name + ": usb",
                 .found = libusb_error_name(code),
                 .remedy = "plug it in again",
                 .kind = ErrorKind::missing_here};
  return std::unique_ptr<UsbLink>(std::make_unique<LibusbLink>(std::move(context), handle));
}

}  // namespace trephine::haptics
