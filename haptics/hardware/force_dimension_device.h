// ForceDimensionDevice: delta, omega, sigma and lambda of Force Dimension, by their library libdhd.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "haptics/hardware/device_exchange.h"

namespace trephine::haptics {

struct ForceDimensionChoice {
  std::size_t index = 0;           ///< among those plugged in
  std::vector<std::string> files;  ///< candidates for the library
};

/// Returns the paths and names of the library in installations of the SDK.
std::vector<std::string> dhd_files();

/// Error if the library cannot be loaded or is too old.
Status check_dhd_library();

/// Force, and torque where the wrist has motors. Its thread exchanges pose and wrench at the rate of the USB.
/// Positions are relative to the centre of the workspace. While the library reports an error, no pose is
/// reported.
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
  int id_ = -1;  ///< of the open device; -1: closed
  DeviceThread thread_;
};

}  // namespace trephine::haptics
