// DeviceExchange: poses from the thread of a driver to the servo, and wrenches back. ExchangeDevice: a device
// with such a thread.
#pragma once

#include "haptics/device/device.h"
#include "haptics/device/latest.h"
#include "haptics/hardware/device_thread.h"

namespace trephine::haptics {

/// The driver's thread reports poses and fetches the wrench to render; the servo reads poses and writes
/// wrenches. No call waits or allocates.
class DeviceExchange {
 public:
  /// Clears pose and wrench. Call while no other thread uses the exchange.
  void restart() noexcept;

  // The driver's thread.
  void report(const glm::dvec3& position, const glm::dquat& orientation, std::uint32_t buttons) noexcept;
  /// Reports that the device was unplugged.
  void report_loss() noexcept;
  /// Returns the servo's newest wrench. It is zero before the first write, and from 50 ms after the last
  /// write. After such a pause it returns gradually, within 0.1 s.
  Wrench wrench() noexcept;

  // The servo's thread.
  /// Returns false before the first report, after a loss, and after 100 ms without a report.
  bool read(double t, Pose& pose) noexcept;
  void write(const Wrench& wrench) noexcept;

 private:
  struct Report {
    glm::dvec3 position{0.0};
    glm::dquat orientation{1, 0, 0, 0};
    std::uint32_t buttons = 0;
    std::uint64_t count = 0;  ///< of reports
    bool is_lost = false;
  };
  struct Request {
    Wrench wrench;
    double seconds = -1e9;  ///< time of the write
  };

  Latest<Report> report_;
  Latest<Request> request_;
  // The driver's thread.
  Report sent_;
  Request newest_;
  double resumed_at_ = -1e9;  ///< end of the last pause of the servo, s
  bool is_paused_ = false;
  // The servo's thread.
  Report last_;
  ReportTimeout silence_{0.1};
};

/// Base of devices with force that a thread of the driver serves. Poses are in the device frame of
/// MappedDevice. The wrench is zero before the servo's first write, and when the last write is more than
/// 50 ms old. A device also sets its force to zero on close(). read() fails before the first pose, after a
/// loss, and after 100 ms without a pose from the device.
class ExchangeDevice : public Device {
 public:
  bool read(double t, Pose& pose) noexcept final { return exchange_.read(t, pose); }
  void write(const Wrench& wrench) noexcept final { exchange_.write(wrench); }

 protected:
  DeviceExchange exchange_;
};

}  // namespace trephine::haptics
