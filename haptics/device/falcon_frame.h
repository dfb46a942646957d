// Frames of the Novint Falcon's firmware: 16 bytes in each direction.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>

namespace trephine::haptics {

/// State of the device in one frame.
struct FalconState {
  std::array<std::int16_t, 3> counts{};  ///< of the encoders
  std::uint8_t homed = 0;                ///< one bit for each arm
  std::uint8_t buttons = 0;              ///< of the grip, four bits

  bool is_homed() const noexcept { return homed == 7; }
};

/// Request to the device: the firmware answers each request with one frame of its state.
struct FalconRequest {
  std::array<double, 3> motors{};  ///< shares of the firmware's greatest value, limited to -1 to 1
  bool homes = false;              ///< the firmware searches for the end positions of the arms
  enum class Light : std::uint8_t { off = 0, green = 2, blue = 4, red = 8 } light = Light::off;
};

inline constexpr std::size_t k_falcon_frame_bytes = 16;
using FalconBytes = std::array<std::uint8_t, k_falcon_frame_bytes>;

/// Encodes a request. Motor values are limited before they are encoded: a value that wrapped around would
/// reverse the force. Values that are not finite are 0.
FalconBytes encode(const FalconRequest& request) noexcept;

/// Finds frames in a stream of bytes. Incomplete and damaged frames are skipped; the next frame begins at the
/// next start byte.
class FalconParser {
 public:
  /// Adds bytes. Returns the state of the last whole frame in them.
  std::optional<FalconState> add(std::span<const std::uint8_t> bytes) noexcept;
  /// Returns the number of damaged frames.
  std::uint64_t damaged() const noexcept { return damaged_; }
  void clear() noexcept { count_ = 0; }

 private:
  FalconBytes frame_{};
  std::size_t count_ = 0;
  std::uint64_t damaged_ = 0;
};

}  // namespace trephine::haptics
