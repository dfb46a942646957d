#include "haptics/hardware/input_file.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cerrno>
#include <cstdlib>
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

/// Returns true for pedals with this kind of node. `vendor`, `product`: as sysfs writes them.
bool is_pedal(NodeKind kind, const std::string& vendor, const std::string& product) {
  for (const UsbIds& ids : usb_ids())
    if (ids.device == "pedal" && ids.node == kind && hex_of(ids.vendor) == vendor)
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

namespace {

/// Returns the number at the end of a name such as "event12".
int number_of(const std::string& name) {
  const std::size_t digit = name.find_first_of("0123456789");
  return digit == std::string::npos ? 0 : std::atoi(name.c_str() + digit);
}

template <class Each>
void for_entries(const char* folder, const Each& each) {
  std::error_code error;
  for (std::filesystem::directory_iterator it(folder, error), end; !error && it != end; it.increment(error))
    each(it->path());
}

struct FoundPedal {
  PedalNode node;
  int number = 0;            ///< of the node
  std::string physical;      ///< path of the USB device that the node belongs to
  bool is_keyboard = false;  ///< the node that reports keys; a pedal may have others, such as a mouse
};

/// Nodes of pedals that report themselves as keyboards.
void add_input_nodes(std::vector<FoundPedal>& found) {
  for_entries("/sys/class/input", [&](const std::filesystem::path& entry) {
    const std::string event = entry.filename();
    if (!event.starts_with("event")) return;
    const std::filesystem::path device = entry / "device";
    if (!is_pedal(NodeKind::input, line_of(device / "id/vendor"), line_of(device / "id/product"))) return;
    const std::string node = "/dev/input/" + event, name = line_of(device / "name"),
                      path = line_of(device / "phys");
    found.push_back({{node, name, ::access(node.c_str(), R_OK) == 0},
                     number_of(event),
                     path.empty() ? node : path.substr(0, path.find('/')),
                     name.find("eyboard") != std::string::npos});
  });
}

/// Nodes of pedals with raw reports.
void add_raw_nodes(std::vector<FoundPedal>& found) {
  for_entries("/sys/class/hidraw", [&](const std::filesystem::path& entry) {
    // A line such as HID_ID=0003:000005F3:000000FF: bus, vendor, product.
    std::ifstream file(entry / "device/uevent");
    std::string name, vendor, product;
    for (std::string line; std::getline(file, line);) {
      std::transform(line.begin(), line.end(), line.begin(), [](unsigned char c) { return std::tolower(c); });
      constexpr std::size_t k_id = 7, k_bus = 5, k_long = 8, k_short = 4;
      if (line.starts_with("hid_id=") && line.size() == k_id + k_bus + 2 * k_long + 1) {
        vendor = line.substr(k_id + k_bus + k_long - k_short, k_short);
        product = line.substr(k_id + k_bus + 2 * k_long + 1 - k_short, k_short);
      }
      if (line.starts_with("hid_name=")) name = line.substr(line.find('=') + 1);
    }
    if (!is_pedal(NodeKind::hidraw, vendor, product)) return;
    const std::string number = entry.filename(), node = "/dev/" + number;
    found.push_back({{node, name, ::access(node.c_str(), R_OK) == 0}, number_of(number), node, true});
  });
}

}  // namespace

std::vector<std::string> event_files_of(const std::string& device) {
  std::vector<std::string> files;
  for_entries((std::filesystem::path(device) / "input").c_str(), [&](const std::filesystem::path& input) {
    for_entries(input.c_str(), [&](const std::filesystem::path& entry) {
      const std::string name = entry.filename();
      if (name.starts_with("event")) files.push_back("/dev/input/" + name);
    });
  });
  std::sort(files.begin(), files.end());
  return files;
}

InputGrab::InputGrab(const std::vector<std::string>& event_files) {
  for (const std::string& name : event_files) {
    const int file = ::open(name.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
    if (file < 0) continue;
    if (::ioctl(file, EVIOCGRAB, 1) == 0)
      files_.push_back(file);
    else
      ::close(file);
  }
}

InputGrab::~InputGrab() {
  for (const int file : files_) ::close(file);
}

std::vector<PedalNode> find_pedals() {
  std::vector<FoundPedal> found, raw;
  add_input_nodes(found);
  add_raw_nodes(raw);
  const auto by_number = [](const FoundPedal& a, const FoundPedal& b) { return a.number < b.number; };
  std::sort(found.begin(), found.end(), by_number);
  std::sort(raw.begin(), raw.end(), by_number);
  found.insert(found.end(), raw.begin(), raw.end());
  // One node for each pedal: that of its keys.
  std::vector<FoundPedal> pedals;
  for (const FoundPedal& one : found) {
    const auto same = std::find_if(pedals.begin(), pedals.end(),
                                   [&](const FoundPedal& other) { return other.physical == one.physical; });
    if (same == pedals.end())
      pedals.push_back(one);
    else if (one.is_keyboard && !same->is_keyboard)
      *same = one;
  }
  std::vector<PedalNode> nodes;
  for (FoundPedal& one : pedals) nodes.push_back(std::move(one.node));
  return nodes;
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
