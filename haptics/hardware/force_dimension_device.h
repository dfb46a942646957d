// ForceDimensionDevice: the devices delta, omega, sigma and lambda of Force Dimension, through the vendor's
// library libdhd.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "haptics/hardware/device_exchange.h"

namespace trephine::haptics {

struct ForceDimensionChoice {
  std::size_t index = 0;           ///< index among the devices that are plugged in
  std::vector<std::string> files;  ///< files of the library, tried in this order
};

/// Returns the files at which an installation of the SDK may have the library: in the folder FORCEDIM_SDK, on
/// the system's search path, and in /usr/local/lib.
std::vector<std::string> dhd_files();

/// Error if the library cannot be loaded or is too old.
Status check_dhd_library();

/// Renders a force, and a torque if the wrist has motors. The device's thread exchanges pose and wrench as
/// often as the USB permits. Positions are relative to the centre of the workspace. An exchange in which the
/// library reports an error returns no pose.
class ForceDimensionDevice final : public ExchangeDevice {
 public:
  explicit ForceDimensionDevice(ForceDimensionChoice choice);
  ~ForceDimensionDevice() override;
  Status open() override;
  void close() noexcept override;
  DeviceCapabilities capabilities() const override { return capabilities_; }

 private:
  struct Functions;
  friend Status check_dhd_library();
  Status load();
  bool step();
  bool send(const Wrench& wrench) noexcept;

  ForceDimensionChoice choice_;
  std::unique_ptr<Functions> dhd_;
  DeviceCapabilities capabilities_;
  bool has_wrist_ = false, has_torque_ = false;
  int id_ = -1;  ///< identifier of the open device; -1: no device is open
  DeviceThread thread_;
};

}  // namespace trephine::haptics
