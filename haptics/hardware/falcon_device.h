// FalconDevice: the Novint Falcon over USB.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "haptics/device/device.h"
#include "haptics/device/falcon_frame.h"
#include "haptics/device/falcon_kinematics.h"
#include "haptics/device/latest.h"
#include "haptics/hardware/device_thread.h"
#include "haptics/hardware/links.h"

namespace trephine::haptics {

struct FalconChoice {
  std::function<Result<std::unique_ptr<UsbLink>>()> open_link;
  /// Returns the firmware of the user, which must not be distributed; called if the device has none.
  std::function<Result<std::vector<std::uint8_t>>()> read_firmware;
  /// Receives instructions for the user while open() waits.
  std::function<void(const std::string&)> notice = [](const std::string&) {};
  double homing_seconds = 30;  ///< open() fails if the arms are not homed by then
  int load_attempts = 5;       ///< of the firmware
};

/// 3 degrees of freedom, 8 N. Its thread exchanges frames at the rate of the USB, about 1 kHz. Poses are in
/// the device frame: see MappedDevice. open() loads the firmware if necessary and waits for homing. The force
/// is zero until the servo writes one, when the servo wrote none for 50 ms, and on close(). read() fails
/// after 100 ms without a frame.
class FalconDevice final : public Device {
 public:
  explicit FalconDevice(FalconChoice choice) : choice_(std::move(choice)) {}
  ~FalconDevice() override { close(); }
  Status open() override;
  void close() noexcept override;
  DeviceCapabilities capabilities() const override;
  bool read(double t, Pose& pose) noexcept override;
  void write(const Wrench& wrench) noexcept override;

 private:
  struct Report {
    glm::dvec3 position{0.0};  ///< from the centre of the workspace
    std::uint32_t buttons = 0;
    std::uint64_t count = 0;  ///< of reports
    bool is_lost = false;
  };
  struct Force {
    glm::dvec3 newtons{0.0};
    std::uint64_t count = 0;  ///< of writes
  };
  Status load();
  Status load_once(const std::vector<std::uint8_t>& image);
  Status home();
  LinkResult exchange(const FalconRequest& request, std::optional<FalconState>& state, int timeout_ms);
  bool step();
  bool adopt(const FalconState& state);
  FalconRequest force_request();

  FalconChoice choice_;
  std::unique_ptr<UsbLink> link_;
  DeviceThread thread_;
  Latest<Report> report_;
  Latest<Force> force_;
  // The thread's.
  FalconParser parser_;
  FalconAngles angles_{};
  glm::dvec3 position_ = FalconKinematics::k_centre;
  Report sent_;
  Force last_force_;
  double force_seconds_ = 0;  ///< time of the last new force
  // The servo's.
  Report last_;
  Force written_;
  Silence silence_{0.1};
};

}  // namespace trephine::haptics
