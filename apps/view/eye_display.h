// EyeDisplay: pictures for two eyes, for a mirror, and for an eye whose position is tracked.
#pragma once

#include <array>
#include <functional>
#include <glm/vec3.hpp>
#include <memory>
#include <optional>

#include "apps/view/display_mode.h"
#include "apps/view/head_tracker.h"

class vtkCamera;
class vtkRenderWindow;
class vtkRenderer;

namespace trephine::view {

class BoneLayer;

/// Moves a camera to an eye at `eye` (mm in the scene: right, up, toward the viewer, from the focal point).
/// The frustum becomes oblique, so that the plane through the focal point keeps its position and size in the
/// picture.
void move_to_eye(vtkCamera* camera, double aspect, const glm::dvec3& eye);

/// Draws the eyes of one window in turn, each by an ordinary frame, and combines their pictures on the
/// graphics card. The parallax is zero at the focal point of the camera. Drawing thread only.
class EyeDisplay {
 public:
  /// `renderer`: has the camera. `last`: the renderer that the window draws last. `tracker` may be null.
  EyeDisplay(vtkRenderWindow* window, vtkRenderer* renderer, vtkRenderer* last, const DisplayMode& mode,
             std::shared_ptr<HeadTracker> tracker);
  ~EyeDisplay();
  EyeDisplay(const EyeDisplay&) = delete;
  EyeDisplay& operator=(const EyeDisplay&) = delete;

  const DisplayMode& mode() const noexcept { return mode_; }
  /// Calls `draw` with the camera of each eye. `draw` draws one frame, and returns false if it would not
  /// change.
  bool render(BoneLayer& bone, const std::function<bool()>& draw);
  /// True while the camera is at an eye.
  bool is_drawing_eye() const noexcept { return eye_ >= 0; }
  /// As of BoneLayer, for both eyes, in the last frame.
  bool is_complete() const;
  double drawn_share() const;

 private:
  glm::dvec3 eye_position(int eye, const std::optional<glm::dvec3>& head, double picture_width,
                          double distance) const;
  std::array<double, 18> centre_view() const;
  void end_frame();

  vtkRenderWindow* window_;
  vtkRenderer *renderer_, *last_;
  DisplayMode mode_;
  std::shared_ptr<HeadTracker> tracker_;
  unsigned long observer_ = 0;  ///< of `last_`
  int eye_ = -1;                ///< eye that is drawn; -1: none
  struct Pictures;
  std::unique_ptr<Pictures> pictures_;
  bool are_eyes_complete_ = false;
  double share_ = 0;
  std::array<double, 18> drawn_view_{};  ///< centre_view() of the last frame
};

}  // namespace trephine::view
