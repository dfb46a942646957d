#include "haptics/hardware/pedal_device.h"

#include <algorithm>
#include <cerrno>
#include <linux/input.h>
#include <poll.h>
#include <unistd.h>

namespace trephine::haptics {

namespace {

constexpr std::size_t k_axis_button = 24;  // bit of the first axis; keys have the lower bits

}  // namespace

Status PedalDevice::open() {
  close();
  auto file = open_input_();
  if (!file) return file.error();
  file_ = std::move(file).value();
  state_ = {}, last_ = {};
  key_count_ = 0;
  report_number_.reset();
  // An axis at rest may be beyond half its range: before it moves, it is no button.
  for (std::size_t i = 0; i < std::min(file_.axes.size(), state_.axes.size()); ++i)
    set_axis(i, file_.axes[i].value);
  shared_.set(state_);
  thread_.start([this] { return file_.is_raw ? receive_report() : receive(); });
  return std::nullopt;
}

void PedalDevice::close() noexcept {
  thread_.stop();
  if (file_.descriptor >= 0) ::close(file_.descriptor);
  file_ = {};
}

DeviceCapabilities PedalDevice::capabilities() const {
  return {
      .name = "pedal", .degrees_of_freedom = 0, .max_force = 0, .max_stiffness = 0, .workspace_radius = 0};
}

std::uint32_t PedalDevice::bit_of_key(int code) noexcept {
  const auto end = keys_.begin() + static_cast<std::ptrdiff_t>(key_count_);
  const auto key = std::find(keys_.begin(), end, code);
  const auto index = static_cast<std::size_t>(key - keys_.begin());
  if (key == end) {
    if (key_count_ == keys_.size()) return 0;
    keys_[key_count_++] = code;
  }
  return 1u << index;
}

/// Sets an axis to a value in the device's units.
void PedalDevice::set_axis(std::size_t axis, int value) noexcept {
  const AxisRange& range = file_.axes[axis];
  if (range.high <= range.low) return;
  const double share =
      (static_cast<double>(value) - range.low) / (static_cast<double>(range.high) - range.low);
  state_.axes[axis] = static_cast<float>(std::clamp(share, 0.0, 1.0));
}

/// Waits for data, and reads up to `size` bytes. Returns the number of bytes; 0: none yet, -1: unplugged.
ssize_t PedalDevice::read_some(void* buffer, std::size_t size) noexcept {
  constexpr int k_wait_ms = 50;
  pollfd waiting{file_.descriptor, POLLIN, 0};
  const int ready = ::poll(&waiting, 1, k_wait_ms);
  if (ready == 0 || (ready < 0 && errno == EINTR)) return 0;
  const ssize_t count = ready < 0 ? -1 : ::read(file_.descriptor, buffer, size);
  if (count < 0 && (errno == EINTR || errno == EAGAIN)) return 0;
  return count > 0 ? count : -1;
}

bool PedalDevice::lose() {
  state_ = {.is_lost = true};
  shared_.set(state_);
  return false;
}

/// Reads one raw report. Returns false after the device was unplugged.
bool PedalDevice::receive_report() {
  std::array<std::uint8_t, 64> report{};
  const ssize_t count = read_some(report.data(), report.size());
  if (count == 0) return true;
  if (count < 0) return lose();
  const std::size_t first = file_.has_report_number ? 1 : 0;
  // Reports with other numbers than the first one have other contents.
  if (file_.has_report_number) {
    if (!report_number_) report_number_ = report[0];
    if (*report_number_ != report[0]) return true;
  }
  state_.buttons = 0;
  for (std::size_t i = 0; i < 3 && first + i < static_cast<std::size_t>(count); ++i)
    state_.buttons |= static_cast<std::uint32_t>(report[first + i]) << (8 * i);
  shared_.set(state_);
  return true;
}

/// Reads one event. Returns false after the device was unplugged.
bool PedalDevice::receive() {
  input_event event{};
  const ssize_t count = read_some(&event, sizeof(event));
  if (count == 0) return true;
  if (count != sizeof(event)) return lose();
  const auto set_button = [&](std::uint32_t bit, bool is_pressed) {
    state_.buttons = is_pressed ? state_.buttons | bit : state_.buttons & ~bit;
  };
  if (event.type == EV_SYN && event.code == SYN_DROPPED) {
    state_.buttons = 0;  // the kernel lost events, such as the release of a key
  } else if (event.type == EV_KEY && event.value != 2) {  // 2: automatic repetition of a held key
    // A pedal that was held when the device was opened has no bit yet: its release gives it none.
    const bool is_known =
        std::find(keys_.begin(), keys_.begin() + static_cast<std::ptrdiff_t>(key_count_), int{event.code}) !=
        keys_.begin() + static_cast<std::ptrdiff_t>(key_count_);
    if (event.value != 0 || is_known) set_button(bit_of_key(event.code), event.value != 0);
  } else if (event.type == EV_ABS) {
    for (std::size_t i = 0; i < std::min(file_.axes.size(), state_.axes.size()); ++i) {
      if (file_.axes[i].code != event.code || file_.axes[i].high <= file_.axes[i].low) continue;
      set_axis(i, event.value);
      set_button(1u << (k_axis_button + i), state_.axes[i] > 0.5f);
      // Until a key was pressed, the first axis also sets the button that activates the tool.
      if (i == 0 && key_count_ == 0) set_button(1, state_.axes[0] > 0.5f);
    }
  }
  shared_.set(state_);
  return true;
}

bool PedalDevice::read(double, Pose& pose) noexcept {
  if (const auto shared = shared_.get()) last_ = *shared;
  if (last_.is_lost) return false;
  pose.buttons = last_.buttons;
  pose.axes = last_.axes;
  return true;
}

}  // namespace trephine::haptics
