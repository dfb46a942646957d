// PedalDevice: reports foot pedals and other input devices of Linux as buttons and axes.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <sys/types.h>

#include "haptics/device/device.h"
#include "haptics/device/latest.h"
#include "haptics/hardware/device_thread.h"

namespace trephine::haptics {

/// Range of one axis of an input device, in the device's units. `code`: the kernel's number of the axis.
/// `value`: position of the axis when the device was opened.
struct AxisRange {
  int code = 0, low = 0, high = 0, value = 0;
};

/// An open input device. PedalDevice closes it.
struct InputFile {
  int descriptor = -1;
  std::vector<AxisRange> axes;  ///< at most four are used
  /// The file returns raw HID reports, and the bits of their first three bytes are buttons.
  /// `has_report_number`: a number precedes these bytes.
  bool is_raw = false, has_report_number = false;
};
using OpenInput = std::function<Result<InputFile>()>;

/// Reads the events of the kernel's input layer, or raw HID reports. Keys, at most 24, are buttons in the
/// order in which they are first pressed: the key that is pressed first activates the tool. Axes are 0 to 1;
/// an axis beyond half its range also counts as a button of its own. Until a key was pressed, the first axis
/// activates the tool. In a raw report, each bit is a button. If the kernel lost events, all keys count as
/// released. The device has no pose.
class PedalDevice final : public Device {
 public:
  explicit PedalDevice(OpenInput open_input) : open_input_(std::move(open_input)) {}
  ~PedalDevice() override { close(); }
  Status open() override;
  void close() noexcept override;
  DeviceCapabilities capabilities() const override;
  bool read(double t, Pose& pose) noexcept override;
  void write(const Wrench&) noexcept override {}

 private:
  struct Shared {
    std::uint32_t buttons = 0;
    std::array<float, 4> axes{};
    bool is_lost = false;
  };
  bool receive();
  bool receive_report();
  void set_axis(std::size_t axis, int value) noexcept;
  ssize_t read_some(void* buffer, std::size_t size) noexcept;
  bool lose();
  std::uint32_t bit_of_key(int code) noexcept;

  OpenInput open_input_;
  InputFile file_;
  // Used by the device's thread.
  Shared state_;
  std::array<int, 24> keys_{};  ///< codes in the order of their first press
  std::size_t key_count_ = 0;
  std::optional<std::uint8_t> report_number_;  ///< of the first raw report
  DeviceThread thread_;
  Latest<Shared> shared_;
  Shared last_;  ///< used by the servo
};

}  // namespace trephine::haptics
