// MouseDevice: a mouse as a stylus; the window sets its pose, the servo reads it at its own rate.
#pragma once

#include <atomic>
#include <cstdint>
#include <optional>
#include <utility>

#include "haptics/device/device.h"
#include "haptics/device/latest.h"

namespace trephine::view {

/// Call set() and release() on the window's thread and read() on the servo's; no call waits. Poses between
/// the window's frames are smoothed, so that a burr does not jump: positions with a time constant of 15 ms
/// (up to 200 ms if the button is down and frames are slow), orientations with one of 80 ms. The depth of a
/// press grows by at most 60 mm/s, so that the window can end the press when the tool slips off an edge of
/// bone.
class MouseDevice final : public haptics::Device {
 public:
  explicit MouseDevice(const glm::dvec3& start_world);
  Status open() override { return std::nullopt; }
  void close() noexcept override {}
  haptics::DeviceCapabilities capabilities() const override { return {"mouse", 3, 0, 0, 1e3}; }
  bool read(double t, haptics::Pose& pose) noexcept override;
  void write(const haptics::Wrench&) noexcept override {}

  /// Sets the requested position (world, mm), the orientation of the tool (unit), and the button. Ignores a
  /// request that is not finite, such as one from a window of size zero. `press_world`: part of the request
  /// by which the tool is pressed into bone. `jump_world`: the pose jumps to the request, without
  /// smoothing and at first without the press, and the proxy starts again at this free point (fetch_jump());
  /// no straight motion connects the two poses.
  void set(const glm::dvec3& request_world, const glm::dquat& turn, bool is_pressed,
           const std::optional<glm::dvec3>& jump_world = {},
           const glm::dvec3& press_world = glm::dvec3(0.0)) noexcept;
  std::optional<glm::dvec3> fetch_jump() noexcept override { return std::exchange(jump_, std::nullopt); }
  /// Releases the button at once, and keeps the requested pose.
  void release() noexcept;
  /// True if the last pose that was read had the button pressed.
  bool is_pressed() const noexcept { return is_pressed_read_; }
  /// Time (s) at which read() returned the first pose without the button after the last press; negative: the
  /// button was never released.
  double released_at() const noexcept { return released_at_; }

 private:
  struct Request {
    glm::dvec3 position{0.0};  ///< without the press
    glm::dvec3 press{0.0};
    glm::dquat turn{1, 0, 0, 0};
    glm::dvec3 free{0.0};     ///< point of the last jump
    std::uint64_t jumps = 0;  ///< number of jumps
    bool is_pressed = false;
  };
  Request sent_;  ///< used by the window's thread only
  haptics::Latest<Request> shared_;
  std::atomic<bool> is_pressed_read_{false};
  std::atomic<double> released_at_{-1};
  // The following members are used by the servo's thread only.
  Request request_;
  glm::dvec3 position_, press_{0.0};
  glm::dquat turn_{1, 0, 0, 0};
  static constexpr double k_seconds = 0.015;  ///< least time constant of positions
  double time_ = 0;                           ///< s, time of the last read()
  double moved_at_ = 0;                       ///< s, time of the last new position
  double time_constant_ = k_seconds;          ///< s, current time constant of positions
  std::optional<glm::dvec3> jump_;            ///< point of a jump, until fetch_jump()
};

}  // namespace trephine::view
