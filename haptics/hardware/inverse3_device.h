// Inverse3Device: Haply's Inverse3 with a VerseGrip, through the vendor's service on this machine.
#pragma once

#include <chrono>
#include <memory>
#include <string>

#include "haptics/hardware/device_exchange.h"
#include "haptics/hardware/web_socket.h"

namespace trephine::haptics {

struct Inverse3Choice {
  std::size_t index = 0;  ///< index among the devices that the service reports
  std::uint16_t port = 10001;
  int lost_ms = 500;  ///< a force that was not answered for this time counts as lost
};

/// Returns the number of Inverse3 devices in the first state that the service on a port sends, at most 16.
/// Error if there is no service.
Result<std::size_t> count_inverse3(std::uint16_t port);

/// Renders a force in 3 degrees of freedom; reports the orientation and the buttons of the grip. The device's
/// thread sends forces, and the service answers each of them with a state. Positions are relative to the
/// position at which open() found the grip. A damaged WebSocket frame ends the force and the connection.
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
  std::string device_;                             ///< identifier that the service reports
  std::string zero_force_;                         ///< message that ends the force
  std::chrono::steady_clock::time_point sent_at_;  ///< time of the last force
  bool is_waiting_ = false;                        ///< the service has not answered the last force
  bool has_force_ = false;                         ///< the last force was not zero
  glm::dvec3 centre_{0.0};
  DeviceThread thread_;
};

}  // namespace trephine::haptics
