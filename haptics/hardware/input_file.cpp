#include "haptics/hardware/input_file.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <filesystem>
#include <fstream>
#include <linux/hidraw.h>
#include <linux/input.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include "haptics/hardware/usb_ids.h"

namespace trephine::haptics {

namespace {

/// Returns true for pedals that report themselves as keyboards. `vendor`, `product`: as sysfs writes them.
bool is_pedal(const std::string& vendor, const std::string& product) {
  for (const UsbIds& ids : usb_ids())
    if (ids.device == "pedal" && ids.node == NodeKind::input && hex_of(ids.vendor) == vendor)
      for (const std::uint16_t known : ids.products)
        if (hex_of(known) == product) return true;
  return false;
}

std::string line_of(const std::filesystem::path& file) {
  std::string line;
  std::getline(std::ifstream(file), line);
  return line;
}

}  // namespace

/// Items of a descriptor begin with a byte that contains their tag and the size of their data.
bool has_report_number(std::span<const std::uint8_t> descriptor) noexcept {
  constexpr std::uint8_t k_report_id = 0x84, k_long_item = 0xfe, k_tag = 0xfc;
  for (std::size_t at = 0; at < descriptor.size();) {
    const std::uint8_t head = descriptor[at];
    if ((head & k_tag) == k_report_id) return true;
    if (head == k_long_item) {
      at += 3 + static_cast<std::size_t>(at + 1 < descriptor.size() ? descriptor[at + 1] : 0);
      continue;
    }
    const std::size_t size = head & 3u;
    at += 1 + (size == 3 ? 4 : size);
  }
  return false;
}

std::vector<PedalNode> find_pedals() {
  std::vector<PedalNode> found;
  std::error_code error;
  for (std::filesystem::directory_iterator it("/sys/class/input", error), end; !error && it != end;
       it.increment(error)) {
    const std::string event = it->path().filename();
    if (!event.starts_with("event")) continue;
    const std::filesystem::path device = it->path() / "device";
    if (!is_pedal(line_of(device / "id/vendor"), line_of(device / "id/product"))) continue;
    const std::string node = "/dev/input/" + event;
    found.push_back({node, line_of(device / "name"), ::access(node.c_str(), R_OK) == 0});
  }
  std::sort(found.begin(), found.end(), [](const auto& a, const auto& b) { return a.node < b.node; });
  return found;
}

Result<InputFile> open_input(const std::string& node) {
  const int file = ::open(node.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  if (file < 0) {
    const bool is_absent = errno == ENOENT || errno == ENODEV || errno == ENXIO;
    return Error{
        .what = is_absent ? "there is no such input device" : "this user may not open the input device",
        .where = is_absent ? "pedal: absent" : "pedal: permission",
        .found = node,
        .remedy = is_absent
                      ? "plug the pedal in; 'ls /dev/input/by-id' lists the devices"
                      : "install packaging/60-trephine.rules in /etc/udev/rules.d, then plug it in again",
        .kind = ErrorKind::missing_here};
  }
  InputFile result{file, {}};
  const auto fail = [&](const char* what, const char* where, const char* remedy) {
    ::close(file);
    return Error{
        .what = what, .where = where, .found = node, .remedy = remedy, .kind = ErrorKind::missing_here};
  };
  // A device of raw reports, which the kernel does not translate into keys.
  hidraw_report_descriptor descriptor{};
  if (int size = 0; ::ioctl(file, HIDIOCGRDESCSIZE, &size) == 0) {
    descriptor.size = static_cast<std::uint32_t>(size);
    if (::ioctl(file, HIDIOCGRDESC, &descriptor) < 0)
      return fail("the device does not describe its reports", "pedal: absent", "plug it in again");
    result.is_raw = true;
    result.has_report_number = has_report_number({descriptor.value, static_cast<std::size_t>(size)});
    return result;
  }
  std::array<unsigned char, ABS_CNT / 8 + 1> bits{};
  if (::ioctl(file, EVIOCGBIT(EV_ABS, bits.size()), bits.data()) < 0)
    return fail("the file is not an input device", "pedal: absent",
                "pass a file of /dev/input, or /dev/hidraw0");
  for (int axis = 0; axis < ABS_CNT && result.axes.size() < 4; ++axis) {
    input_absinfo range{};
    if ((bits[static_cast<std::size_t>(axis) / 8] >> axis % 8 & 1) == 0) continue;
    if (::ioctl(file, EVIOCGABS(axis), &range) < 0 || range.maximum <= range.minimum) continue;
    result.axes.push_back({axis, range.minimum, range.maximum, range.value});
  }
  if (::ioctl(file, EVIOCGRAB, 1) < 0)
    return fail("another program holds the pedal", "pedal: busy", "close the other program");
  return result;
}

}  // namespace trephine::haptics
