// EyeDisplay: pictures for two eyes, for a mirror, for an eye whose position is tracked, and for a headset.
#pragma once

#include <array>
#include <functional>
#include <glm/vec3.hpp>
#include <memory>
#include <optional>

#include "apps/view/display_mode.h"
#include "apps/view/head_tracker.h"
#include "apps/view/hmd.h"

class vtkCamera;
class vtkRenderWindow;
class vtkRenderer;

namespace trephine::view {

class BoneLayer;

/// Moves a camera to an eye at `eye` (mm in the scene: right, up, toward the viewer, from the focal point).
/// The frustum becomes oblique, so that the plane through the focal point keeps its position and size in the
/// picture.
void move_to_eye(vtkCamera* camera, double aspect, const glm::dvec3& eye);

/// Moves a camera to an eye of a headset. The focal point is `distance` mm in front of `start`, an eye
/// position with a horizontal line of sight; the scene is scaled so that the camera is at this distance from
/// it.
void move_to_headset_eye(vtkCamera* camera, const HmdEye& eye, const HmdEye& start, double distance);

/// Returns the mean of two eyes, with a horizontal line of sight.
HmdEye horizontal_middle(const std::array<HmdEye, 2>& eyes);

/// Draws the eyes of one window in turn, each by an ordinary frame, and combines their pictures on the
/// graphics card. The parallax is zero at the focal point of the camera. Drawing thread only.
class EyeDisplay {
 public:
  /// `renderer`: has the camera. `last`: the renderer that the window draws last, which has the texts; they
  /// do not appear in a headset. `tracker` may be null; `hmd` may be null except for the mode headset.
  EyeDisplay(vtkRenderWindow* window, vtkRenderer* renderer, vtkRenderer* last, const DisplayMode& mode,
             std::shared_ptr<HeadTracker> tracker, std::shared_ptr<Hmd> hmd);
  ~EyeDisplay();
  EyeDisplay(const EyeDisplay&) = delete;
  EyeDisplay& operator=(const EyeDisplay&) = delete;

  const DisplayMode& mode() const noexcept { return mode_; }
  /// Calls `draw` with the camera of each eye. `draw` draws one frame, and returns false if it would not
  /// change.
  bool render(BoneLayer& bone, const std::function<bool()>& draw);
  /// Returns once why the headset ended; the window then shows ordinary pictures.
  Status take_problem();
  /// A paused headset receives no pictures: the window draws ordinary frames.
  void pause(bool is_paused) noexcept { is_paused_ = is_paused; }
  /// True while the camera is at an eye.
  bool is_drawing_eye() const noexcept { return eye_ >= 0; }
  /// As of BoneLayer, for both eyes, in the last frame.
  bool is_complete() const;
  double drawn_share() const;

 private:
  glm::dvec3 eye_position(int eye, const std::optional<glm::dvec3>& head, double picture_width,
                          double distance) const;
  std::array<double, 18> centre_view() const;
  bool render_headset(BoneLayer& bone, const std::function<bool()>& draw);
  void keep_headset_eye();
  void combine();
  void end_frame();

  vtkRenderWindow* window_;
  vtkRenderer *renderer_, *last_;
  DisplayMode mode_;
  std::shared_ptr<HeadTracker> tracker_;
  std::shared_ptr<Hmd> hmd_;
  std::optional<HmdEye> start_;               ///< of the headset, see move_to_headset_eye()
  std::array<unsigned long, 2> observers_{};  ///< of `last_`
  bool is_problem_taken_ = false, is_paused_ = false;
  int eye_ = -1;  ///< eye that is drawn; -1: none
  struct Pictures;
  std::unique_ptr<Pictures> pictures_;
  bool are_eyes_complete_ = false;
  double share_ = 0;
  std::array<double, 18> drawn_view_{};  ///< centre_view() of the last frame
};

}  // namespace trephine::view
