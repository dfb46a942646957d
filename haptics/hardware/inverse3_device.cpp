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
    return Error{.what = result == LinkResult::done
                             ? "the service of Haply reports no Inverse3 with this number"
                             : "the service of Haply sends no state",
                 .where = "inverse3: absent",
                 .found = "",
                 .expected = "at least " + std::to_string(choice_.index + 1) + " Inverse3",
                 .remedy = "plug the Inverse3 in, switch it on, and wait until its light is steady",
                 .kind = ErrorKind::missing_here};
  if (!state->is_calibrated)
    return Error{.what = "the Inverse3 is not calibrated",
                 .where = "inverse3: not homed",
                 .remedy = "move its arm into the calibration position until its light is steady",
                 .kind = ErrorKind::missing_here};
  socket_ = std::move(socket).value();
  device_ = state->device;
  zero_force_ = inverse3_force(device_, {0, 0, 0});
  centre_ = state->position;
  is_waiting_ = has_force_ = false;
  exchange_.restart();
  exchange_.report({0, 0, 0}, state->orientation, state->buttons);
  thread_.start([this] {
    bool goes_on = false;
    try {
      goes_on = step();
    } catch (...) {
      // If memory is exhausted, the device counts as lost.
    }
    if (!goes_on) {
      exchange_.report_loss();
      end_force();
    }
    return goes_on;
  });
  return std::nullopt;
}

/// Sends a last message without force.
void Inverse3Device::end_force() noexcept {
  try {
    socket_->send(zero_force_, k_send_ms);
  } catch (...) {
    // If memory is exhausted, no message is sent: only the end of the connection stops the force.
  }
}

void Inverse3Device::close() noexcept {
  thread_.stop();
  if (!socket_) return;
  end_force();
  socket_.reset();
}

/// Sends a force if the service has answered the previous one, and reads the newest state. At most one force
/// is unanswered: a second one would wait in the service, and would delay all later forces. Returns false if
/// the connection ended.
bool Inverse3Device::step() {
  using namespace std::chrono;
  const glm::dvec3 force = exchange_.wrench().force_world;
  const bool is_ending =
      force == glm::dvec3(0) && has_force_;  // an end of the force does not wait for an answer
  if (!is_waiting_ || is_ending) {
    const LinkResult sent = socket_->send(inverse3_force(device_, force), k_send_ms);
    if (sent == LinkResult::timed_out) return true;
    if (sent != LinkResult::done) return false;
    is_waiting_ = true, sent_at_ = steady_clock::now();
    has_force_ = force != glm::dvec3(0);
  }
  std::string message;
  LinkResult result = socket_->receive(message, k_state_ms);
  if (result == LinkResult::timed_out) {
    // If the last force counts as lost, the next call sends another one.
    is_waiting_ = steady_clock::now() - sent_at_ < milliseconds(choice_.lost_ms);
    return true;
  }
  for (std::string newer; result == LinkResult::done;) {
    is_waiting_ = false;
    if ((result = socket_->receive(newer, 0)) == LinkResult::done) message.swap(newer);
  }
  if (result != LinkResult::timed_out) return false;
  // The number of this device changes when another one is unplugged.
  for (std::size_t i = 0; i < k_most_devices; ++i) {
    const auto state = parse_inverse3(message, (choice_.index + i) % k_most_devices);
    if (!state || state->device != device_) continue;
    exchange_.report(state->position - centre_, state->orientation, state->buttons);
    break;
  }
  return true;
}

}  // namespace trephine::haptics
