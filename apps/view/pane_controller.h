// Panes of an operation or a replay: they follow its settings (focus, position of the C-arm,
// shots), and pass the user's actions to it.
#pragma once

#include <functional>
#include <optional>

#include "apps/imaging/panes.h"
#include "haptics/servo/servo_core.h"
#include "sim/overlay.h"

namespace trephine::view {

/// State of one frame; borrowed for it.
struct PaneNews {
  const haptics::TouchScene& scene;
  std::shared_ptr<const volume::Version> version;
  bool is_changed = false;                  ///< matter, since the last frame
  const sim::Overlays* overlays = nullptr;  ///< null: none
  const sim::Overlays* plan = nullptr;
  std::span<const std::shared_ptr<const sim::Value>> settings;  ///< of modules
  std::span<const std::shared_ptr<const sim::Forbidden>> forbidden;
  const haptics::ServoRecord& newest;
  bool is_tool_there = true;  ///< on or over something
  double elapsed = 0;         ///< s, since the last frame
  volume::Eye eye;            ///< as the picture is seen
  std::optional<volume::Openings::Plane> clip;
  std::span<const sim::SeenDepths> depths = {};
};

/// No windowing toolkit in here. The thread that draws; images are made on another.
class PaneController {
 public:
  explicit PaneController(std::size_t panes) : panes_(panes) {}

  imaging::Panes& panes() noexcept { return panes_; }
  /// Sends a command to the operation; null in a replay: then pictures cost no dose.
  std::function<void(sim::Value)> tell;
  /// Another operation.
  void begin();
  /// True: there are new images.
  bool frame(const PaneNews& news);
  /// Replaces frame() while no pane is visible: nothing is exposed, and shots of that time need no image.
  void rest(std::span<const std::shared_ptr<const sim::Value>> settings);

  /// Makes the focus follow the tool while it touches.
  bool follows_tool = true;
  /// Tip of the tool and a point up its shaft; null: it is not known.
  const std::array<glm::dvec3, 2>* tool() const noexcept { return tool_ ? &*tool_ : nullptr; }

  // The C-arm. Of a scan that cannot be X-rayed nothing is exposed.
  void set_preset(std::size_t preset);
  void shoot();
  /// Reports every live second as one shot of `k_pulses` of `k_pulse`.
  void set_live(bool is_live);
  static constexpr double k_pulses = 15, k_pulse = 0.008;  ///< 1/s; s

  /// Plane by which the section clips the picture: a place and a normal. Empty: it does not.
  struct Clip {
    glm::dvec3 at, normal;
    friend bool operator==(const Clip&, const Clip&) = default;
  };
  const std::optional<Clip>& clip() const noexcept { return clip_; }

 private:
  void follow(std::span<const std::shared_ptr<const sim::Value>> settings);
  void place_arm();
  void tell_exposure();

  imaging::Panes panes_;
  std::optional<std::array<glm::dvec3, 2>> tool_;
  std::vector<std::shared_ptr<const sim::Value>> followed_;  ///< settings as they were
  std::int64_t shots_ = 0;
  bool is_placed_ = false;  ///< the operation knows where the C-arm stands
  int told_ = 0;            ///< live exposures that were reported and not confirmed yet
  double exposed_ = 0;      ///< s of live pictures that were not reported yet
  std::optional<Clip> clip_;
};

}  // namespace trephine::view
