// TouchDevice: the devices Touch, Touch X, Omni and Phantom of 3D Systems, through the library libHD of
// OpenHaptics.
#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "haptics/hardware/device_exchange.h"

namespace trephine::haptics {

struct TouchChoice {
  std::string name;  ///< name of the device in the vendor's configuration; empty: the default device
  std::vector<std::string> files{"libHD.so.3.4", "libHD.so"};  ///< files of the library, tried in this order
  /// Receives instructions for the user while open() waits.
  std::function<void(const std::string&)> notice = [](const std::string&) {};
  std::function<bool()> should_stop = [] { return false; };  ///< see DeviceHost
  double calibration_seconds = 30;  ///< open() fails if the device is not calibrated by then
  double reset_seconds = 3;         ///< time from the notice until the arm must be at its reset position
};

/// Error if the library of OpenHaptics cannot be loaded or is too old.
Status check_touch_library();

/// Reports 6 degrees of freedom and renders a force, without torque. The library's scheduler exchanges frames
/// at 1 kHz; a program can open at most one device. Positions are relative to the centre of the usable
/// workspace. After the library reported hot motors or an excessive force, the force is zero for 0.5 s. A
/// frame in which the library reports any other error returns no pose.
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
    unsigned code = 0;  ///< an error of the device if there was one, else an error of the force; 0: no error
    bool is_of_force = false, is_of_device = false;
  };
  Errors take_errors() noexcept;
  bool step() noexcept;
  static unsigned tick(void* device) noexcept;

  TouchChoice choice_;
  std::unique_ptr<Functions> hd_;
  DeviceCapabilities capabilities_;
  glm::dvec3 centre_{0.0};  ///< centre of the usable workspace, mm, in the library's frame
  unsigned id_;             ///< handle of the open device
  unsigned long schedule_ = 0;
  bool is_scheduled_ = false;
  int pause_ticks_ = 0;  ///< remaining ticks without force; used by the scheduler's thread
  std::atomic<bool> is_closing_{false};
  std::atomic<int> closing_ticks_{0};  ///< number of ticks since is_closing_ was set
};

}  // namespace trephine::haptics
