// BoneView: picture of bone, cuts, instrument, proxy and force. This header includes no VTK header.
#pragma once

#include <glm/vec3.hpp>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "apps/view/bone_layer.h"
#include "apps/view/eye_display.h"
#include "apps/view/overlay_layer.h"
#include "apps/view/screen_depth.h"
#include "apps/view/structure_layer.h"
#include "apps/view/stylus_actors.h"

class vtkRenderer;
class vtkRenderWindow;

namespace trephine::view {

/// All contents of one window. Drawing thread only.
class BoneView {
 public:
  /// Adds its renderers to the window. If `is_live`, a frame draws only changes; otherwise it draws
  /// everything, with screen-space ambient occlusion. `has_scenery`: adds a renderer for scenery to a live
  /// window.
  BoneView(vtkRenderWindow* window, bool is_live, bool has_scenery = false);
  ~BoneView();
  BoneView(const BoneView&) = delete;
  BoneView& operator=(const BoneView&) = delete;

  BoneLayer& bone();
  const BoneLayer& bone() const;
  /// Shows the instrument of a hand, from 0.
  void show(const StylusState& stylus, std::size_t hand = 0);
  OverlayLayer& overlays();
  /// Returns the boxes of all labels and small marks of the last frame, in pixels from the lower left.
  std::vector<LabelLayer::Box> label_boxes() const;
  /// Shows marks in front of everything, in place of the previous ones. Live windows only.
  void set_marks(std::span<const sim::Overlay> marks);
  /// Returns the layer of whole structures, which are drawn behind translucent bone; null if not live.
  StructureLayer* structures();
  /// Draws the bone with an opacity from 0 to 1 over structures and tools; nullopt: opaque, without
  /// structures. Live windows only.
  void set_bone_opacity(std::optional<double> opacity);
  /// Returns the layer of the scenery, which is touched by its depth on the screen; null without scenery, or
  /// if not live.
  OverlayLayer* scenery();
  /// Returns the reader of the depth of the scenery on the screen; null without scenery, or if not live.
  ScreenDepth* screen_depth();
  /// Makes the GL context current; returns false if that fails.
  bool is_drawable();
  /// Shows lines of text in the upper left corner, and one line at the bottom centre.
  void show_text(const std::string& corner, const std::string& foot);
  /// Distance (mm) of the camera from which a whole world box is visible.
  static double distance_of(const glm::dvec3& low, const glm::dvec3& high);
  /// Sets the camera's angle from the size of the window. If the width is below 0.9 of the height, the angle
  /// is wider, so that the width shows as much as at a ratio of 0.9. Runs before each frame; call it before
  /// using the camera outside a frame.
  void fit_camera();
  /// Moves the camera to `distance` mm from `target` along `from` (unit), with `up` upward.
  void aim_camera(const glm::dvec3& target, const glm::dvec3& from, const glm::dvec3& up, double distance);
  /// Shows a whole world box from the side A, P, L, R, S or I of the patient. Any other `side`, such as 0:
  /// from the front, the left and above.
  void look_from(char side, const glm::dvec3& low, const glm::dvec3& high);
  /// Sets how the window presents its picture; `tracker`: position of the viewer's head, or null; `hmd`: for
  /// the mode headset. A plain mode without a tracker has no cost. Live windows only.
  void set_display(const DisplayMode& mode, std::shared_ptr<HeadTracker> tracker,
                   std::shared_ptr<Hmd> hmd = nullptr);
  /// Returns the presentation; null for a plain picture without a tracker.
  EyeDisplay* eyes() const;
  /// Draws one frame. Returns false, without drawing, if the picture would not change.
  bool render();
  /// Sets the factor of the text size of letters, scale bar and labels. In a small window the factor is
  /// limited.
  void set_text_scale(double factor);

  vtkRenderer* renderer();
  /// World box of the shown bone; without bone, a cube of 100 mm around the origin.
  void bounds(glm::dvec3& low, glm::dvec3& high) const;

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace trephine::view
