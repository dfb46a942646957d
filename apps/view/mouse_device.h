// MouseDevice: a mouse as a stylus; the window sets its pose, the servo reads it at its own rate.
#pragma once

#include <array>
#include <atomic>
#include <optional>
#include <utility>

#include "haptics/device/device.h"

namespace trephine::view {

/// Call set() and release() on the window's thread and read() on the servo's; no call waits. Poses between
/// the window's 60 Hz are smoothed, so that a burr does not jump: positions with a time constant of 15 ms,
/// orientations with 80 ms.
class MouseDevice final : public haptics::Device {
 public:
  explicit MouseDevice(const glm::dvec3& start_world);
  Status open() override { return std::nullopt; }
  void close() noexcept override {}
  haptics::DeviceCapabilities capabilities() const override { return {"mouse", 3, 0, 0, 1e3}; }
  bool read(double t, haptics::Pose& pose) noexcept override;
  void write(const haptics::Wrench&) noexcept override {}

  /// Sets the requested position (world, mm), orientation of the tool (unit) and button. Ignores a request
  /// that is not finite, as from a picture without a size. `jump_world`: the tool is lifted over to this free
  /// point, without smoothing, instead of moving along a straight line.
  void set(const glm::dvec3& request_world, const glm::dquat& turn, bool is_pressed,
           const std::optional<glm::dvec3>& jump_world = {}) noexcept;
  std::optional<glm::dvec3> take_jump() noexcept override { return std::exchange(jump_, std::nullopt); }
  /// Releases the button at once, and leaves the requested pose.
  void release() noexcept { is_pressed_ = false; }
  /// True if the last pose that was read had the button pressed.
  bool is_pressed() const noexcept { return is_pressed_read_; }
  /// Time (s) of the first pose without the button after the last one with it; negative: never pressed.
  double released_at() const noexcept { return released_at_; }

 private:
  // A sequence lock for one writer: odd while it writes. The reader tries a few times, then keeps its last
  // request.
  std::atomic<unsigned> sequence_{0};
  /// x, y, z of the position; w, x, y, z of the orientation; x, y, z of the last jump; number of jumps
  std::array<std::atomic<double>, 11> shared_;
  std::atomic<bool> is_pressed_{false}, is_pressed_read_{false};
  std::atomic<double> released_at_{-1};
  glm::dvec3 request_, position_;
  glm::dquat requested_turn_{1, 0, 0, 0}, turn_{1, 0, 0, 0};
  bool pressed_ = false;
  double time_ = 0, jumps_ = 0;     ///< s of the last read; number of jumps that were read
  std::optional<glm::dvec3> jump_;  ///< of the last read
};

}  // namespace trephine::view
