// FalconDevice: the Novint Falcon over USB.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "haptics/device/device.h"
#include "haptics/device/falcon_frame.h"
#include "haptics/device/falcon_kinematics.h"
#include "haptics/hardware/device_exchange.h"
#include "haptics/hardware/links.h"

namespace trephine::haptics {

struct FalconChoice {
  std::function<Result<std::unique_ptr<UsbLink>>()> open_link;
  /// Returns the firmware image that the user supplies, since it must not be distributed. Called if no
  /// firmware runs on the device.
  std::function<Result<std::vector<std::uint8_t>>()> read_firmware;
  /// Receives instructions for the user while open() waits.
  std::function<void(const std::string&)> notice = [](const std::string&) {};
  std::function<bool()> should_stop = [] { return false; };  ///< see DeviceHost
  double homing_seconds = 30;  ///< open() fails if the arms are not homed by then
  int load_attempts = 5;       ///< of the firmware
};

/// 3 degrees of freedom, 8 N. Its thread exchanges frames at the rate of the USB, about 1 kHz. open() loads
/// the firmware if necessary and waits for homing.
class FalconDevice final : public ExchangeDevice {
 public:
  explicit FalconDevice(FalconChoice choice) : choice_(std::move(choice)) {}
  ~FalconDevice() override { close(); }
  Status open() override;
  void close() noexcept override;
  DeviceCapabilities capabilities() const override;

 private:
  Status load();
  Status load_once(const std::vector<std::uint8_t>& image);
  Status home();
  void end_force() noexcept;
  LinkResult exchange_frame(const FalconRequest& request, std::optional<FalconState>& state, int timeout_ms);
  bool step();
  bool adopt(const FalconState& state);
  FalconRequest force_request();

  FalconChoice choice_;
  std::unique_ptr<UsbLink> link_;
  DeviceThread thread_;
  // Used by open(), then by the thread only.
  FalconParser parser_;
  FalconAngles angles_{};
  glm::dvec3 position_ = FalconKinematics::k_centre;
};

}  // namespace trephine::haptics
