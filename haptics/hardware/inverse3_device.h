// Inverse3Device: Haply's Inverse3 with a VerseGrip, by the vendor's service on this machine.
#pragma once

#include <chrono>
#include <memory>
#include <string>

#include "haptics/hardware/device_exchange.h"
#include "haptics/hardware/web_socket.h"

namespace trephine::haptics {

struct Inverse3Choice {
  std::size_t index = 0;  ///< among those of the service
  std::uint16_t port = 10001;
};

/// Returns the number of devices that the service on a port reports. Error if there is no service.
Result<std::size_t> count_inverse3(std::uint16_t port);

/// Force in 3 degrees of freedom, orientation and buttons of the grip. Its thread sends a force, and the
/// service answers with a state. Positions are relative to that of the grip when the device was opened. A
/// damaged WebSocket frame ends the force and the connection.
class Inverse3Device final : public ExchangeDevice {
 public:
  explicit Inverse3Device(const Inverse3Choice& choice) : choice_(choice) {}
  ~Inverse3Device() override { close(); }
  Status open() override;
  void close() noexcept override;
  DeviceCapabilities capabilities() const override;

 private:
  bool step();
  void end_force() noexcept;

  Inverse3Choice choice_;
  std::unique_ptr<WebSocket> socket_;
  std::string device_;      ///< identifier
  std::string zero_force_;  ///< message
  std::chrono::steady_clock::time_point asked_at_;
  bool is_waiting_ = false;  ///< for the state that answers the last force
  glm::dvec3 centre_{0.0};
  DeviceThread thread_;
};

}  // namespace trephine::haptics
