// Fuzzes what devices send, in pieces. The environment variable PARSER (0 to 5) selects one parser; without
// it, the first byte of the input does.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <span>
#include <thread>
#include <unistd.h>

#include "haptics/device/falcon_frame.h"
#include "haptics/device/falcon_kinematics.h"
#include "haptics/device/spacemouse.h"
#include "haptics/hardware/input_file.h"
#include "haptics/hardware/inverse3_message.h"
#include "haptics/hardware/pedal_device.h"
#include "haptics/hardware/web_socket.h"

using namespace trephine::haptics;

namespace {

void require(bool condition) {
  if (!condition) std::abort();
}

bool is_finite(const glm::dvec3& v) { return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z); }

/// Calls each(piece) for the bytes after the first one, in order. The first byte plus 1 is the size of a
/// piece.
template <class Each>
void in_pieces(std::span<const std::uint8_t> bytes, const Each& each) {
  if (bytes.empty()) return;
  const std::size_t size = 1 + bytes[0];
  for (bytes = bytes.subspan(1); !bytes.empty(); bytes = bytes.subspan(std::min(size, bytes.size())))
    each(bytes.first(std::min(size, bytes.size())));
}

void fuzz_falcon(std::span<const std::uint8_t> bytes) {
  FalconParser parser;
  in_pieces(bytes, [&](std::span<const std::uint8_t> piece) {
    const auto state = parser.add(piece);
    if (!state) return;
    FalconAngles angles;
    for (std::size_t i = 0; i < 3; ++i) angles[i] = FalconKinematics::angle_of(state->counts[i]);
    const auto position = FalconKinematics::forward(angles);
    if (!position) return;
    require(is_finite(*position));
    if (const auto torques = FalconKinematics::torques(angles, *position, {1, 2, 3}))
      for (const double torque : *torques) require(std::isfinite(torque));
  });
}

void fuzz_spacemouse(std::span<const std::uint8_t> bytes) {
  SpaceMouseParser parser;
  RatePose pose((RateControl()));
  in_pieces(bytes, [&](std::span<const std::uint8_t> piece) {
    parser.add(piece);
    pose.move(parser.state(), 0.01);
    require(is_finite(pose.position()) && std::isfinite(pose.orientation().w));
  });
}

void fuzz_web_socket(std::span<const std::uint8_t> bytes) {
  WebSocketParser parser;
  bool is_over = false;
  in_pieces(bytes, [&](std::span<const std::uint8_t> piece) {
    if (is_over) return;
    parser.add(piece);
    for (auto found = parser.next(); found != WebSocketParser::Found::nothing; found = parser.next()) {
      is_over = found == WebSocketParser::Found::invalid || found == WebSocketParser::Found::closed;
      if (is_over) break;
      require(parser.message().size() <= WebSocketParser::k_largest_message);
      (void)parse_inverse3(parser.message(), 0);
    }
  });
}

void fuzz_inverse3(std::span<const std::uint8_t> bytes) {
  const auto state = parse_inverse3({reinterpret_cast<const char*>(bytes.data()), bytes.size()}, 0);
  if (!state) return;
  require(is_finite(state->position));
  require(std::abs(glm::dot(state->orientation, state->orientation) - 1) < 1e-9);
  require(!inverse3_force(state->device, {1, 2, 3}).empty());
}

/// The other end of a pipe sends the bytes, then closes it.
void fuzz_pedal(std::span<const std::uint8_t> bytes) {
  if (bytes.empty()) return;
  int ends[2];
  require(::pipe(ends) == 0);
  PedalDevice pedal([&]() -> trephine::Result<InputFile> {
    return InputFile{.descriptor = ends[0],
                     .axes = {{0, -5, 5, 0}, {1, 0, 255, 255}, {2, 7, 7, 7}},
                     .is_raw = (bytes[0] & 1) != 0,
                     .has_report_number = (bytes[0] & 2) != 0};
  });
  constexpr std::size_t k_most = 4096;  // bytes; a pipe holds more
  const auto sent = bytes.subspan(1).first(std::min(bytes.size() - 1, k_most));
  require(::write(ends[1], sent.data(), sent.size()) == static_cast<ssize_t>(sent.size()));
  ::close(ends[1]);
  require(!pedal.open());
  Pose pose;
  for (int i = 0; i < 1000 && pedal.read(0.001 * i, pose); ++i) {
    for (const float axis : pose.axes) require(axis >= 0 && axis <= 1);
    std::this_thread::yield();
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size < 2) return 0;
  const std::span<const std::uint8_t> rest(data + 1, size - 1);
  static const char* const selected = std::getenv("PARSER");
  switch (selected ? std::atoi(selected) : data[0] % 6) {
    case 0:
      fuzz_falcon(rest);
      break;
    case 1:
      fuzz_spacemouse(rest);
      break;
    case 2:
      fuzz_web_socket(rest);
      break;
    case 3:
      fuzz_inverse3(rest);
      break;
    case 4:
      fuzz_pedal(rest);
      break;
    default:
      (void)has_report_number(rest);
  }
  return 0;
}
