// TouchDevice: Touch, Touch X, Omni and Phantom of 3D Systems, by the library libHD of OpenHaptics.
#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "haptics/hardware/device_exchange.h"

namespace trephine::haptics {

struct TouchChoice {
  std::string name;  ///< of the device in the vendor's configuration; empty: the default one
  std::vector<std::string> files{"libHD.so.3.4", "libHD.so"};  ///< candidates for the library
  /// Receives instructions for the user while open() waits.
  std::function<void(const std::string&)> notice = [](const std::string&) {};
  double calibration_seconds = 30;  ///< open() fails if the device is not calibrated by then
  double reset_seconds = 3;         ///< for the hand to bring the arm to its reset position
};

/// Error if the library of OpenHaptics cannot be loaded or is too old.
Status check_touch_library();

/// 6 degrees of freedom, 3 of them with force. The library's scheduler exchanges frames at 1 kHz; a program
/// can open one device. Positions are relative to the centre of the usable workspace. The force is also zero
/// for 0.5 s after the library reported hot motors or an excessive force. A frame with another error of the
/// library reports no pose.
class TouchDevice final : public ExchangeDevice {
 public:
  explicit TouchDevice(TouchChoice choice);
  ~TouchDevice() override;
  Status open() override;
  void close() noexcept override;
  DeviceCapabilities capabilities() const override { return capabilities_; }

 private:
  struct Functions;
  friend Status check_touch_library();
  Status load();
  Status calibrate();
  void read_capabilities();
  struct Errors {
    unsigned code = 0;  ///< of one error, which concerns the device if any does; 0: no error
    bool is_of_force = false, is_of_device = false;
  };
  Errors take_errors() noexcept;
  bool step() noexcept;
  static unsigned tick(void* device) noexcept;

  TouchChoice choice_;
  std::unique_ptr<Functions> hd_;
  DeviceCapabilities capabilities_;
  glm::dvec3 centre_{0.0};  ///< of the usable workspace, in the library's frame
  unsigned id_;             ///< of the open device
  unsigned long schedule_ = 0;
  bool is_scheduled_ = false;
  int pause_ticks_ = 0;  ///< without force; the scheduler's thread
  std::atomic<bool> is_closing_{false};
  std::atomic<int> last_ticks_{0};  ///< number of ticks since is_closing_ was set
};

}  // namespace trephine::haptics
