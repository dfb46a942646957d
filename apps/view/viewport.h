// Picture of an operation: bone, cut, stylus and overlays at one moment, live or replayed.
#pragma once

#include <functional>
#include <memory>
#include <optional>

#include "apps/view/bone_view.h"
#include "apps/view/opened_structures.h"
#include "haptics/servo/servo_core.h"
#include "sim/depth_sets.h"
#include "volume/direct_image.h"
#include "volume/traversal.h"

namespace trephine::view {

struct Ray {
  glm::dvec3 origin, direction;  // world, unit direction
};

/// Cuts the picture open by a plane that faces the viewer, or an axis of the patient, or any.
struct ClipChoice {
  enum class Axis { none, left, back, up, view, plane } axis = Axis::none;
  double share = 0.5;          ///< of the way through the bone, 0 to 1; not of a plane:
  glm::dvec3 at{0.0};          ///< world
  glm::dvec3 normal{0, 0, 1};  ///< unit; nothing before it is shown
};

/// And where the depth images are made.
sim::Overlays with_clip_volumes(sim::Overlays overlays, std::span<const sim::SeenDepths> depths);

/// Borrows the scene. One thread: the one that draws.
class Viewport {
 public:
  Viewport(const haptics::TouchScene& scene, vtkRenderWindow* window, bool is_live);

  /// Asks for the surface of a version, all of it or where it changed. wait: until all of it is there.
  void request_all(const std::shared_ptr<const volume::Version>& version);
  void request(const std::shared_ptr<const volume::Version>& version, const volume::VoxelBox& changed);
  void wait();
  /// Shows other shapes of the same scan for a while (a window that a person is choosing), or again its own.
  void preview(std::unique_ptr<haptics::TouchScene> shapes,
               const std::shared_ptr<const volume::Version>& version);
  void set_clip(const ClipChoice& choice);
  const ClipChoice& clip() const noexcept { return clip_; }
  /// Half space that this cuts away: all before this plane.
  std::optional<volume::Openings::Plane> clip_plane() const;
  /// Camera of the picture, in its own pixels.
  volume::Eye eye();
  /// Turns the picture about what is looked at, degrees; the patient's head stays up.
  void turn(double left, double up);

  /// Goes nearer by a factor, toward what is seen at (x, y), as ray_at() takes it, and no nearer than 20 mm.
  void zoom(const volume::Version& version, double factor, double x, double y);

  /// mm, of the ball that the tool touches with by now; 0: a point.
  void set_touch_radius(double radius) { touch_radius_ = radius; }
  /// Shows the stylus as a tick left it. One without an orientation leans as `held_at()` has it.
  void show_stylus(const haptics::ServoRecord& record, ToolLook tool, const volume::Version& version,
                   const glm::dvec3& toward_viewer);
  /// Direction of the shaft of a ball on a surface, so that one sees what it does: between the normal and the
  /// viewer. Unit.
  static glm::dvec3 held_at(const glm::dvec3& normal, const glm::dvec3& toward_viewer);
  /// Draws a line on the bone, world, with the stylus: the edge that a tool goes under. Empty: none.
  void mark_edge(std::vector<glm::dvec3> line) { edge_ = std::move(line); }
  /// Sets what is always shown in addition to the bone: a plan.
  void set_plan(sim::Overlays plan);
  /// Shows other overlays in addition, and no more; `hands`: the newest tick of each.
  void show(std::span<const sim::Overlay> overlays, std::span<const haptics::ServoRecord> hands);
  std::size_t overlay_count() { return view_.overlays().size(); }
  void show_text(const std::string& corner, const std::string& foot) { view_.show_text(corner, foot); }
  /// A state as a picture has it, without a tool: all of it, seen from `from` (unit), aimed between the
  /// bone's middle (`share` 0) and a place (1), `nearer` (1: as far as all of it needs).
  void show_still(const std::shared_ptr<const volume::Version>& version,
                  std::span<const sim::Overlay> overlays, const glm::dvec3& at, const glm::dvec3& from,
                  double share, double nearer);
  /// From `out` a little to the side and above, so that depth is seen. Unit.
  static glm::dvec3 obliquely(const glm::dvec3& out);
  /// All of the bone, seen from one of A P L R S I, or from the front left above (0).
  void look_from(char side) { view_.look_from(side, seen_low_, seen_high_); }
  /// Seen from where a surgeon stands who works at a place: from outside, a little aside.
  void look_at_work(const glm::dvec3& at_world);
  /// Takes finished chunks in and draws. Returns the milliseconds that it took; nothing where the picture
  /// would be the same as the last one, and was not drawn.
  std::optional<double> draw();

  /// Through the picture at (x, y), shares of its width and height from the lower left.
  Ray ray_at(double x, double y);
  /// Returns where a place of the world is in the picture, as ray_at() takes it.
  glm::dvec2 project(const glm::dvec3& at_world);
  /// First crossing of the ray with the solid of any shape, mm along it, in the part that is not clipped
  /// away; negative when it does not.
  double distance_to_solid(const volume::Version& version, const Ray& ray) const;
  /// Finds the place at which a tool that does not work rests along the ray. Through an opening in what was
  /// solid before anything was cut it goes no farther than the first labelled structure behind it, or, where
  /// nothing is near, the far side of what was removed; not to the far side of the skull.
  struct RestingPlace {
    double distance = -1;  ///< mm along the ray; negative: it meets nothing
    bool is_soft = false;  ///< over an opening: nothing there holds the tool
  };
  RestingPlace resting_place(const volume::Version& version, const Ray& ray) const;
  /// Unit, out of the solid: how the surface lies on the whole, some millimetres around where the ray meets
  /// it. Nothing where there is too little of it.
  std::optional<glm::dvec3> facing(const volume::Version& version, const Ray& ray) const;
  /// Above everything, where an idle stylus waits.
  glm::dvec3 outside_point() const;
  /// Unit normal of the first shape's surface, out of the solid; 0 where it is flat.
  glm::dvec3 normal_at(const volume::Version& version, const glm::dvec3& p_world) const;

  /// Scenery: requests its depth on the screen around a place, in the next frame; returns the result. Empty
  /// where there is no scenery, or nothing is ready.
  void ask_depth(const glm::dvec3& at, double edge);
  std::optional<ScreenDepth::Seen> take_depth();
  BoneView& view() noexcept { return view_; }
  std::size_t triangle_count() const { return view_.bone().triangle_count(); }
  bool is_complete() const;
  /// Returns the share of the picture that is drawn in full, 0 to 1; 1: it is complete.
  double drawn_share() const;
  /// Draws until the picture is complete. False where the window cannot be drawn into.
  bool complete();

 private:
  /// Gives finished chunks of bone and of opened structures to the picture.
  void take_meshes();
  /// Calls visit(distance along the ray, voxel, is it solid as scanned, is it solid now) along the ray, past
  /// the plane that cuts the picture open, while it returns true.
  template <class Visit>
  void follow(const volume::Version& version, const Ray& ray, const Visit& visit) const;
  sim::Overlays plan_;
  std::shared_ptr<const volume::Version> version_;  ///< whose surface was asked for last
  std::vector<glm::dvec3> edge_;
  const haptics::TouchScene* scene_;
  vtkRenderWindow* window_;
  BoneView view_;
  std::unique_ptr<haptics::TouchScene> preview_;
  std::unique_ptr<ChunkWorker> worker_;
  OpenedStructures structures_;
  ClipChoice clip_;
  double touch_radius_;
  glm::dvec3 low_{0.0}, high_{0.0};            ///< world box of all that is solid
  glm::dvec3 seen_low_{0.0}, seen_high_{0.0};  ///< and of models in addition
  glm::dvec3 clip_origin_{0.0}, clip_normal_{0.0};
};

}  // namespace trephine::view
