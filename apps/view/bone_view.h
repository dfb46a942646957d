// Picture of an operation: bone, cut, stylus with burr, proxy, force. All VTK lives behind this.
#pragma once

#include <glm/gtc/quaternion.hpp>
#include <glm/vec3.hpp>
#include <memory>
#include <string>
#include <vector>

#include "apps/view/bone_layer.h"
#include "apps/view/overlay_layer.h"
#include "apps/view/screen_depth.h"
#include "apps/view/tool_look.h"

class vtkRenderer;
class vtkRenderWindow;

namespace trephine::view {

/// Appearance of the instrument; world frame, mm, N.
struct StylusLook {
  bool is_visible = true;
  glm::dvec3 hip_world{0.0};
  ToolLook tool = {};
  glm::dvec3 tool_world{0.0};   ///< where the origin of its frame is, ...
  glm::dquat turn{1, 0, 0, 0};  ///< ... and how it is turned
  bool has_contact = false;
  glm::dvec3 proxy_world{0.0};
  glm::dvec3 force_world{0.0};
  /// Depth cue: a ring on the bone below the tool, which closes in as it comes near; none when not set.
  bool has_ring = false;
  glm::dvec3 ring_world{0.0}, ring_normal_world{0, 0, 1};
  std::vector<glm::dvec3> edge = {};  ///< line on the bone; empty: none
};

/// Everything in one window. One thread: the one that draws.
class BoneView {
 public:
  /// Adds its renderers to the window. Live: frames cost what changed in them. Not live: pictures, with
  /// ambient occlusion in the image. Scenery is drawn by itself only where there is some: live, then.
  BoneView(vtkRenderWindow* window, bool is_live, bool has_scenery = false);
  ~BoneView();
  BoneView(const BoneView&) = delete;
  BoneView& operator=(const BoneView&) = delete;

  BoneLayer& bone();
  const BoneLayer& bone() const;
  void show(const StylusLook& stylus);
  OverlayLayer& overlays();
  /// Scenery that is touched as it is drawn, and its depth on the screen; null without scenery or a live
  /// window.
  OverlayLayer* scenery();
  ScreenDepth* screen_depth();
  /// Makes the GL context current.
  bool is_drawable();
  /// Lines of text in the upper left corner, and one below in the middle.
  void show_text(const std::string& corner, const std::string& foot);
  /// From which all of a world box is seen, mm.
  static double distance_of(const glm::dvec3& low, const glm::dvec3& high);
  /// Camera `distance` mm from `target` along `from` (unit), `up` upward.
  void aim_camera(const glm::dvec3& target, const glm::dvec3& from, const glm::dvec3& up, double distance);
  /// All of a world box, seen from one of A P L R S I, or from the front left above (0).
  void look_from(char side, const glm::dvec3& low, const glm::dvec3& high);
  /// Draws one frame. Returns false, and draws nothing, where the picture would be the same as the last one.
  bool render();
  /// Letters, scale bar and labels: times the size that they have otherwise.
  void set_text_scale(double factor);

  vtkRenderer* renderer();
  /// World box of what is shown.
  void bounds(glm::dvec3& low, glm::dvec3& high) const;

 private:
  void fit_text();
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace trephine::view
