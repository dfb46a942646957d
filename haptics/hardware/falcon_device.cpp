#include "haptics/hardware/falcon_device.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <thread>

#include "haptics/device/device_kind.h"

namespace trephine::haptics {

using glm::dvec3;

namespace {

// Requests to the serial converter (FTDI), with the values that the Falcon needs.
constexpr std::uint8_t k_reset = 0, k_modem = 1, k_flow = 2, k_baud = 3, k_data = 4, k_latency = 9;
constexpr std::uint16_t k_purge_receive = 1, k_purge_send = 2;
constexpr std::uint16_t k_rts_low = 0x200, k_dtr_low = 0x100, k_dtr_high = 0x101;
constexpr std::uint16_t k_baud_9600 = 0x4138, k_baud_140k = 0x15, k_baud_1500k = 2;
constexpr std::uint16_t k_8n1 = 8, k_no_flow = 0;
constexpr std::uint16_t k_loading_latency = 16, k_running_latency = 1;  // ms

constexpr std::size_t k_packet = 64, k_status = 2;  // bytes of a USB packet, and of the status that begins it
constexpr std::size_t k_block = 62;                 // bytes of the firmware that are echoed together
constexpr int k_frame_ms = 20;
constexpr int k_reply_ms = 1000;

/// Share of the firmware's greatest motor value, 4095, per torque, 1/(N mm): 10 units per N mm. The sign is
/// that of the motors.
constexpr double k_share_per_torque = -10.0 / 4095;

Error lost() {
  return {.what = "the Falcon stopped responding",
          .where = "falcon: silent",
          .remedy = "check its power supply, and plug it in without a hub"};
}

/// Appends the data of USB packets without the status bytes of the converter.
void append_data(std::span<const std::uint8_t> bytes, std::vector<std::uint8_t>& data) {
  for (std::size_t i = 0; i < bytes.size(); i += k_packet) {
    const std::size_t end = std::min(i + k_packet, bytes.size());
    for (std::size_t k = i + k_status; k < end; ++k) data.push_back(bytes[k]);
  }
}

/// Reads until `data` has `count` bytes, or until `timeout_ms` have passed.
LinkResult receive(UsbLink& link, std::size_t count, int timeout_ms, std::vector<std::uint8_t>& data) {
  std::array<std::uint8_t, 8 * k_packet> buffer;
  const double until = seconds_now() + 1e-3 * timeout_ms;
  while (data.size() < count) {
    std::size_t read = 0;
    const LinkResult result = link.read(buffer, read, timeout_ms);
    if (result == LinkResult::disconnected || result == LinkResult::failed) return result;
    append_data(std::span(buffer).first(std::min(read, buffer.size())), data);
    if (data.size() < count && seconds_now() > until) return LinkResult::timed_out;
  }
  return LinkResult::done;
}

/// Sends requests until one fails.
LinkResult control(UsbLink& link, std::initializer_list<std::pair<std::uint8_t, std::uint16_t>> requests) {
  for (const auto& [request, value] : requests)
    if (const LinkResult result = link.control(request, value); result != LinkResult::done) return result;
  return LinkResult::done;
}

/// Sets the converter to the speed of a running firmware.
LinkResult set_running(UsbLink& link) {
  return control(link, {{k_reset, k_purge_receive},
                        {k_reset, k_purge_send},
                        {k_latency, k_running_latency},
                        {k_baud, k_baud_1500k},
                        {k_data, k_8n1},
                        {k_flow, k_no_flow}});
}

}  // namespace

DeviceCapabilities FalconDevice::capabilities() const {
  return {.name = "Novint Falcon",
          .degrees_of_freedom = 3,
          .max_force = 8,
          .max_stiffness = 1,
          .workspace_radius = FalconKinematics::k_workspace_radius};
}

Status FalconDevice::open() {
  close();
  auto link = choice_.open_link();
  if (!link) return link.error();
  link_ = std::move(link).value();
  parser_.clear();
  position_ = FalconKinematics::k_centre;
  exchange_.restart();

  // A running firmware answers a frame without force.
  std::optional<FalconState> state;
  bool is_running = false;
  if (set_running(*link_) == LinkResult::done)
    for (int attempt = 0; attempt < 3 && !is_running; ++attempt)
      is_running = exchange_frame({}, state, 50) == LinkResult::done && state;
  Status error = is_running ? std::nullopt : load();
  if (!error) error = home();
  if (error) {
    link_.reset();
    return error;
  }
  thread_.start([this] { return step(); });
  return std::nullopt;
}

void FalconDevice::close() noexcept {
  thread_.stop();
  if (!link_) return;
  end_force();
  link_.reset();
}

/// Loads the firmware, which often takes several attempts.
Status FalconDevice::load() {
  auto image = choice_.read_firmware();
  if (!image) return image.error();
  Status error;
  for (int attempt = 1; attempt <= choice_.load_attempts; ++attempt) {
    if (choice_.should_stop()) return cancelled("falcon");
    choice_.notice("loading the firmware of the Falcon, attempt " + std::to_string(attempt) + " of " +
                   std::to_string(choice_.load_attempts));
    error = load_once(image.value());
    if (!error || error->where == "falcon: absent") return error;
    std::this_thread::sleep_for(std::chrono::milliseconds(50 * attempt));
  }
  return error;
}

Status FalconDevice::load_once(const std::vector<std::uint8_t>& image) {
  const auto failed = [](const char* part, LinkResult result) {
    return result == LinkResult::disconnected
               ? Error{.what = "the Falcon was unplugged while its firmware was loaded",
                       .where = "falcon: absent",
                       .remedy = "plug it in, and start again"}
               : Error{.what = std::string("the firmware of the Falcon could not be loaded: ") + part,
                       .where = "falcon: firmware",
                       .remedy = "switch the Falcon off and on, plug it in without a hub, and start again"};
  };
  LinkResult result = control(*link_, {{k_reset, k_purge_receive},
                                       {k_reset, k_purge_send},
                                       {k_latency, k_loading_latency},
                                       {k_baud, k_baud_9600},
                                       {k_data, k_8n1},
                                       {k_flow, k_no_flow},
                                       {k_modem, k_rts_low},
                                       {k_modem, k_dtr_low},
                                       {k_modem, k_dtr_high}});
  if (result != LinkResult::done) return failed("the converter refused its settings", result);

  // The loader identifies itself; some converters put a zero in front of its answer.
  constexpr std::array<std::uint8_t, 3> k_question{0x0a, 0x43, 0x0d};
  constexpr std::array<std::uint8_t, 4> k_answer{0x0a, 0x44, 0x2c, 0x0d};
  result = link_->write(k_question, k_reply_ms);
  std::vector<std::uint8_t> data;
  if (result == LinkResult::done) result = receive(*link_, k_answer.size(), k_reply_ms, data);
  if (result == LinkResult::done && data.front() == 0) {
    if (data.size() <= k_answer.size()) result = receive(*link_, k_answer.size() + 1, k_reply_ms, data);
    data.erase(data.begin());
  }
  if (result != LinkResult::done || data.size() < k_answer.size() ||
      !std::equal(k_answer.begin(), k_answer.end(), data.begin()))
    return failed("its loader does not answer", result);

  constexpr std::array<std::uint8_t, 1> k_begin{0x41};
  result = control(*link_, {{k_modem, k_dtr_low}, {k_baud, k_baud_140k}});
  if (result == LinkResult::done) result = link_->write(k_begin, k_reply_ms);
  data.clear();
  if (result == LinkResult::done) result = receive(*link_, 1, k_reply_ms, data);
  if (result != LinkResult::done || data.front() != k_begin[0])
    return failed("its loader does not begin", result);

  for (std::size_t at = 0; at < image.size(); at += k_block) {
    const auto block = std::span(image).subspan(at, std::min(k_block, image.size() - at));
    result = link_->write(block, k_reply_ms);
    data.clear();
    if (result == LinkResult::done) result = receive(*link_, block.size(), k_reply_ms, data);
    if (result != LinkResult::done || data.size() != block.size() ||
        !std::equal(block.begin(), block.end(), data.begin()))
      return failed("a block was not echoed", result);
  }
  result = set_running(*link_);
  if (result != LinkResult::done) return failed("the converter refused its settings", result);
  parser_.clear();
  std::optional<FalconState> state;
  for (int attempt = 0; attempt < 20; ++attempt) {
    result = exchange_frame({}, state, 50);
    if (state) return std::nullopt;
    if (result == LinkResult::disconnected) break;
  }
  return failed("it does not run", result);
}

/// Waits until the user moved the grip through its range.
Status FalconDevice::home() {
  const double begin = seconds_now();
  double answered = begin;
  bool is_asked = false;
  while (true) {
    std::optional<FalconState> state;
    const LinkResult result =
        exchange_frame({.homes = true, .light = FalconRequest::Light::red}, state, k_frame_ms);
    const double now = seconds_now();
    if (choice_.should_stop()) return cancelled("falcon");
    if (state) answered = now;
    if (state && state->is_homed() && adopt(*state)) return std::nullopt;
    if (result == LinkResult::disconnected || result == LinkResult::failed || now - answered > 1)
      return lost();
    if (!is_asked && state)
      choice_.notice(
          "Falcon: pull the grip out, then push it in fully. The light turns blue when it is ready.");
    is_asked = is_asked || state;
    if (now - begin > choice_.homing_seconds)
      return Error{.what = "the Falcon was not homed in time",
                   .where = "falcon: not homed",
                   .remedy = "pull the grip out and push it in fully while its light is red"};
  }
}

/// Sends a request and reads until a frame is complete or the time is over.
LinkResult FalconDevice::exchange_frame(const FalconRequest& request, std::optional<FalconState>& state,
                                        int timeout_ms) {
  if (const LinkResult sent = link_->write(encode(request), timeout_ms); sent != LinkResult::done)
    return sent;
  std::array<std::uint8_t, 8 * k_packet> buffer;
  const double until = seconds_now() + 1e-3 * timeout_ms;
  do {
    std::size_t count = 0;
    const LinkResult result = link_->read(buffer, count, timeout_ms);
    if (result == LinkResult::disconnected || result == LinkResult::failed) return result;
    count = std::min(count, buffer.size());
    for (std::size_t i = 0; i < count; i += k_packet) {
      const std::size_t end = std::min(i + k_packet, count);
      if (end <= i + k_status) continue;
      if (const auto found = parser_.add(std::span(buffer).subspan(i + k_status, end - i - k_status)))
        state = found;
    }
    if (state) return LinkResult::done;
  } while (seconds_now() < until);
  return LinkResult::timed_out;
}

/// Returns the motor values of the servo's newest force at the current position.
FalconRequest FalconDevice::force_request() {
  FalconRequest request{.light = FalconRequest::Light::blue};
  const auto torques = FalconKinematics::torques(angles_, position_, exchange_.wrench().force_world);
  if (!torques) return request;
  // Limited together, so that the direction of the force is kept.
  double greatest = 1;
  for (const double torque : *torques) greatest = std::max(greatest, std::abs(k_share_per_torque * torque));
  for (std::size_t i = 0; i < 3; ++i) request.motors[i] = k_share_per_torque * (*torques)[i] / greatest;
  return request;
}

/// Exchanges one frame. Returns false after the device was unplugged.
bool FalconDevice::step() {
  std::optional<FalconState> state;
  const LinkResult result = exchange_frame(force_request(), state, k_frame_ms);
  if (result == LinkResult::disconnected || result == LinkResult::failed) {
    exchange_.report_loss();
    end_force();  // the error may be that of a device that is still plugged in
    return false;
  }
  // After a drop of its supply the device has to be homed again; until then its counts have no meaning.
  if (state && state->is_homed()) adopt(*state);
  return true;
}

/// Sends frames without force: the motors would keep their last values.
void FalconDevice::end_force() noexcept {
  constexpr int k_frames = 3;
  for (int i = 0; i < k_frames; ++i) (void)link_->write(encode({}), k_frame_ms);
}

/// Reports the position of a state. Returns false if its counts fit no position.
bool FalconDevice::adopt(const FalconState& state) {
  FalconAngles angles;
  for (std::size_t i = 0; i < 3; ++i) angles[i] = FalconKinematics::angle_of(state.counts[i]);
  auto position = FalconKinematics::forward(angles, position_);
  if (!position) position = FalconKinematics::forward(angles);
  if (!position) return false;
  angles_ = angles;
  position_ = *position;
  exchange_.report(position_ - FalconKinematics::k_centre, {1, 0, 0, 0}, state.buttons);
  return true;
}

}  // namespace trephine::haptics
