// PaneController: makes panes follow the settings of an operation or a replay (focus, pose of the C-arm,
// shots), and sends the user's actions to the operation.
#pragma once

#include <functional>
#include <memory>
#include <optional>

#include "apps/imaging/panes.h"
#include "haptics/servo/servo_core.h"
#include "sim/api/overlay.h"
#include "volume/scan/surgical_plan.h"

namespace trephine::view {

/// State of one frame; borrowed for the call.
struct PaneInput {
  const haptics::TouchScene& scene;
  std::shared_ptr<const volume::Version> version;
  bool is_changed = false;                                      ///< matter changed since the last frame
  const sim::Overlays* overlays = nullptr;                      ///< null: no overlays
  std::shared_ptr<const volume::SurgicalPlan> plan;             ///< null: no plan
  std::span<const std::shared_ptr<const sim::Value>> settings;  ///< settings of modules
  std::span<const std::shared_ptr<const sim::Forbidden>> forbidden;
  const haptics::ServoRecord& newest;
  double touch_radius = 0;        ///< mm, of the ball with which the tool touches; 0: a point
  bool is_tool_at_object = true;  ///< the tool touches or is over an object
  bool is_inserted = false;       ///< the tool is in its track or in a structure, where it may touch nothing
  double elapsed = 0;             ///< s, since the last frame
  volume::Camera camera;          ///< camera of the 3-D view
  std::optional<volume::Openings::Plane> clip;
  std::span<const sim::DisplayedDepths> depths = {};
  const sim::Value* tool = nullptr;  ///< the instrument, which casts a shadow in X-rays; null: none
};

/// Independent of the windowing toolkit. Drawing thread only; images are rendered on another thread.
class PaneController {
 public:
  explicit PaneController(std::size_t panes) : panes_(panes) {}

  imaging::Panes& panes() noexcept { return panes_; }
  /// Sends a command to the operation; null in a replay, in which images cause no dose.
  std::function<void(sim::Value)> apply;
  /// Resets everything for another operation.
  void begin();
  /// Updates the panes. Returns true if there are new images.
  bool frame(const PaneInput& input);
  /// Replaces frame() while no pane is visible and no shot is due: ends live X-rays.
  void rest(std::span<const std::shared_ptr<const sim::Value>> settings);
  /// True if the operation has executed a shot whose image is not taken yet. False in a replay.
  bool is_shot_due(std::span<const std::shared_ptr<const sim::Value>> settings) const;

  /// True: the focus follows the contact point while the tool touches, or the tip of an inserted tool. After
  /// a jump in a replay, the focus is the tip.
  bool follows_tool = true;
  /// Tip of the tool and a point up its shaft; null if unknown.
  const std::array<glm::dvec3, 2>* tool() const noexcept { return tool_ ? &*tool_ : nullptr; }

  // C-arm. Without Hounsfield units, the X-ray pane shows the reason why there is no image.
  void set_preset(std::size_t preset);
  void shoot();
  /// Switches live X-rays on or off. Reports each live second as one shot of
  /// k_pulses_per_second pulses.
  void set_live(bool is_live);
  static constexpr double k_pulses_per_second = 15, k_pulse_seconds = 0.008;  ///< of live X-rays

  /// Plane by which the section clips the picture; nullopt: no clipping.
  struct Clip {
    glm::dvec3 at, normal;
    friend bool operator==(const Clip&, const Clip&) = default;
  };
  const std::optional<Clip>& clip() const noexcept { return clip_; }

 private:
  void show_tool_in_xrays(const PaneInput& input);
  void follow(std::span<const std::shared_ptr<const sim::Value>> settings);
  void confirm_live_shots(std::int64_t shots);
  void place_arm();
  void report_exposure();

  sim::Value shadow_instrument_;                     ///< instrument of `shadow_`
  std::shared_ptr<const haptics::MeshTree> shadow_;  ///< surface of the instrument; null: no instrument
  imaging::Panes panes_;
  std::optional<std::array<glm::dvec3, 2>> tool_;
  std::vector<std::shared_ptr<const sim::Value>> followed_;  ///< settings of the last frame
  /// Known shots of the operation: each further shot needs an image. nullopt before the first frame.
  std::optional<std::int64_t> shots_;
  bool is_placed_ = false;     ///< the pose of the C-arm was sent to the operation, or set by it
  int unconfirmed_shots_ = 0;  ///< live exposures that were reported but not confirmed yet
  double exposed_ = 0;         ///< duration of live X-rays not yet reported, s
  double shown_t_ = 0;         ///< s, time of the last frame's record
  std::optional<Clip> clip_;
};

}  // namespace trephine::view
