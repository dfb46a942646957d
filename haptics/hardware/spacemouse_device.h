// SpaceMouseDevice: a 3Dconnexion SpaceMouse as a tool without force.
#pragma once

#include <functional>
#include <memory>

#include "haptics/device/device.h"
#include "haptics/device/latest.h"
#include "haptics/device/spacemouse.h"
#include "haptics/hardware/device_thread.h"
#include "haptics/hardware/links.h"

namespace trephine::haptics {

using OpenHidLink = std::function<Result<std::unique_ptr<HidLink>>()>;

/// The deflection moves the tool (RatePose); buttons are those of the device. Poses are in the device frame
/// of MappedDevice. A device that sends nothing for 30 ms counts as at rest. read() fails after the device
/// was unplugged or the connection failed.
class SpaceMouseDevice final : public Device {
 public:
  explicit SpaceMouseDevice(OpenHidLink open_link, const RateControl& control = {});
  ~SpaceMouseDevice() override { close(); }
  Status open() override;
  void close() noexcept override;
  DeviceCapabilities capabilities() const override;
  bool read(double t, Pose& pose) noexcept override;
  void write(const Wrench&) noexcept override {}

 private:
  struct Shared {
    SpaceMouseState state;
    bool is_lost = false;
  };
  bool receive();

  OpenHidLink open_link_;
  RateControl control_;
  std::unique_ptr<HidLink> link_;
  SpaceMouseParser parser_;  ///< used by the device's thread
  Latest<Shared> shared_;
  DeviceThread thread_;
  // Used by the servo.
  RatePose pose_;
  Shared last_;
  double time_ = 0;
  bool has_time_ = false;
};

}  // namespace trephine::haptics
