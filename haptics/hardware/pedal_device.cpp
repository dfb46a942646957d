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
  shared_.set(state_);
  thread_.start([this] { return receive(); });
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

/// Reads one event. Returns false after the device was unplugged.
bool PedalDevice::receive() {
  constexpr int k_wait_ms = 50;
  pollfd waiting{file_.descriptor, POLLIN, 0};
  const int ready = ::poll(&waiting, 1, k_wait_ms);
  if (ready == 0 || (ready < 0 && errno == EINTR)) return true;
  input_event event{};
  const ssize_t count = ready < 0 ? -1 : ::read(file_.descriptor, &event, sizeof(event));
  if (count < 0 && (errno == EINTR || errno == EAGAIN)) return true;
  if (count != sizeof(event)) {
    state_ = {.is_lost = true};
    shared_.set(state_);
    return false;
  }
  const auto set_button = [&](std::uint32_t bit, bool is_pressed) {
    state_.buttons = is_pressed ? state_.buttons | bit : state_.buttons & ~bit;
  };
  if (event.type == EV_KEY && event.value != 2) {  // 2: automatic repetition of a held key
    set_button(bit_of_key(event.code), event.value != 0);
  } else if (event.type == EV_ABS) {
    for (std::size_t i = 0; i < std::min(file_.axes.size(), state_.axes.size()); ++i) {
      const AxisRange& axis = file_.axes[i];
      if (axis.code != event.code || axis.high <= axis.low) continue;
      const double share =
          (static_cast<double>(event.value) - axis.low) / (static_cast<double>(axis.high) - axis.low);
      state_.axes[i] = static_cast<float>(std::clamp(share, 0.0, 1.0));
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
