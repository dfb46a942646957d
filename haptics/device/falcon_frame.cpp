#include "haptics/device/falcon_frame.h"

#include <algorithm>
#include <cmath>

namespace trephine::haptics {

namespace {

// A frame: start, three values of four digits each (16-bit, the lowest digit first), flags, one unused byte,
// end. Each digit, and the flags, are encoded as k_zero plus the value.
constexpr std::uint8_t k_start = '<', k_end = '>', k_zero = 'A';
constexpr std::size_t k_flags = 13;
constexpr double k_greatest = 4095;  // of a motor; the firmware's converter has 12 bits and a sign

}  // namespace

FalconBytes encode(const FalconRequest& request) noexcept {
  FalconBytes bytes;
  bytes.fill(k_zero);
  bytes.front() = k_start, bytes.back() = k_end;
  for (std::size_t i = 0; i < 3; ++i) {
    const double share = std::isfinite(request.motors[i]) ? std::clamp(request.motors[i], -1.0, 1.0) : 0;
    const auto value = static_cast<std::uint16_t>(static_cast<std::int16_t>(std::lround(k_greatest * share)));
    for (std::size_t digit = 0; digit < 4; ++digit)
      bytes[1 + 4 * i + digit] = static_cast<std::uint8_t>(k_zero + (value >> 4 * digit & 15));
  }
  bytes[k_flags] =
      static_cast<std::uint8_t>(k_zero + (static_cast<int>(request.light) | (request.homes ? 1 : 0)));
  return bytes;
}

std::optional<FalconState> FalconParser::add(std::span<const std::uint8_t> bytes) noexcept {
  std::optional<FalconState> last;
  for (const std::uint8_t byte : bytes) {
    // A start byte within a frame begins the next one: the digits and flags have no such value.
    if (byte == k_start) {
      damaged_ += count_ > 0;
      count_ = 0;
    } else if (count_ == 0) {
      continue;
    }
    frame_[count_++] = byte;
    const bool is_last = count_ == frame_.size();
    const bool is_no_digit = count_ > 1 && count_ <= k_flags && !(byte >= k_zero && byte <= k_zero + 15);
    if (is_no_digit || (is_last && byte != k_end)) {
      ++damaged_;
      count_ = 0;
      continue;
    }
    if (!is_last) continue;
    count_ = 0;
    FalconState state;
    for (std::size_t i = 0; i < 3; ++i) {
      unsigned value = 0;
      for (std::size_t digit = 0; digit < 4; ++digit)
        value |= static_cast<unsigned>(frame_[1 + 4 * i + digit] - k_zero) << 4 * digit;
      state.counts[i] = static_cast<std::int16_t>(static_cast<std::uint16_t>(value));
    }
    const auto flags = static_cast<unsigned>(static_cast<std::uint8_t>(frame_[k_flags] - k_zero));
    state.buttons = static_cast<std::uint8_t>(flags & 15);
    state.homed = static_cast<std::uint8_t>(flags >> 4 & 7);
    last = state;
  }
  return last;
}

}  // namespace trephine::haptics
