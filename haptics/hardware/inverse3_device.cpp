#include "haptics/hardware/inverse3_device.h"

#include "haptics/hardware/inverse3_message.h"

namespace trephine::haptics {

namespace {

constexpr int k_connect_ms = 500, k_first_ms = 1000, k_state_ms = 20, k_send_ms = 20;
constexpr std::size_t k_most_devices = 16;

}  // namespace

Result<std::size_t> count_inverse3(std::uint16_t port) {
  auto socket = WebSocket::connect(port, k_connect_ms);
  if (!socket) return socket.error();
  std::string message;
  std::size_t count = 0;
  if (socket.value()->receive(message, k_first_ms) == LinkResult::done)
    while (count < k_most_devices && parse_inverse3(message, count)) ++count;
  return count;
}

DeviceCapabilities Inverse3Device::capabilities() const {
  return {.name = "Haply Inverse3",
          .degrees_of_freedom = 6,
          .max_force = 8,
          .max_stiffness = 1,
          .workspace_radius = 100};
}

Status Inverse3Device::open() {
  close();
  auto socket = WebSocket::connect(choice_.port, k_connect_ms);
  if (!socket) {
    Error error = socket.error();
    error.where = "inverse3: service";
    error.remedy = "start the Haply Inverse Service";
    return error;
  }
  std::string message;
  const LinkResult result = socket.value()->receive(message, k_first_ms);
  const auto state = result == LinkResult::done ? parse_inverse3(message, choice_.index) : std::nullopt;
  if (!state)
    return Error{.what = result == LinkResult::done ? "the service of Haply reports no such Inverse3"
                                                    : "the service of Haply sends no state",
                 .where = "inverse3: absent",
                 .found = "",
                 .expected = "at least " + std::to_string(choice_.index + 1),
                 .remedy = "plug the Inverse3 in, switch it on, and wait until its light is steady",
                 .kind = ErrorKind::missing_here};
  if (!state->is_calibrated)
    return Error{.what = "the Inverse3 is not calibrated",
                 .where = "inverse3: not homed",
                 .remedy = "move its arm into the calibration position until its light is steady",
                 .kind = ErrorKind::missing_here};
  socket_ = std::move(socket).value();
  device_ = state->device;
  centre_ = state->position;
  exchange_.restart();
  exchange_.report({0, 0, 0}, state->orientation, state->buttons);
  thread_.start([this] { return step(); });
  return std::nullopt;
}

void Inverse3Device::close() noexcept {
  thread_.stop();
  if (!socket_) return;
  socket_->send(inverse3_force(device_, {0, 0, 0}), k_send_ms);
  socket_.reset();
}

/// Sends a force and reads the state that answers it. Returns false when the connection ended.
bool Inverse3Device::step() {
  const LinkResult sent = socket_->send(inverse3_force(device_, exchange_.wrench().force_world), k_send_ms);
  std::string message;
  const LinkResult result = sent == LinkResult::done ? socket_->receive(message, k_state_ms) : sent;
  if (result == LinkResult::gone || result == LinkResult::failed) {
    exchange_.report_loss();
    return false;
  }
  if (result == LinkResult::timed_out) return true;  // the next force asks for the next state
  const auto state = parse_inverse3(message, choice_.index);
  if (state && state->device == device_)
    exchange_.report(state->position - centre_, state->orientation, state->buttons);
  return true;
}

}  // namespace trephine::haptics
