// Viewport: picture of an operation: bone, cuts, stylus and overlays at one moment, live or replayed.
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <optional>

#include "apps/view/bone_view.h"
#include "apps/view/opened_structures.h"
#include "apps/view/structure_surfaces.h"
#include "apps/view/structures.h"
#include "haptics/servo/servo_core.h"
#include "sim/engine/depth_sets.h"
#include "volume/imaging/direct_image.h"
#include "volume/scan/traversal.h"

namespace trephine::view {

struct Ray {
  glm::dvec3 origin, direction;  // world, unit direction
};

/// Clip plane of the picture, which faces the viewer, an axis of the patient, or any direction.
struct ClipChoice {
  enum class Axis { none, left, back, up, view, plane } axis = Axis::none;
  double share = 0.5;          ///< depth of the plane through the bone, 0 to 1; not for Axis::plane
  glm::dvec3 at{0.0};          ///< Axis::plane: point of the plane, world, mm
  glm::dvec3 normal{0, 0, 1};  ///< Axis::plane: unit, toward the side that is not shown
};

/// Returns the overlays with the clip volumes of depth images added.
sim::Overlays with_clip_volumes(sim::Overlays overlays, std::span<const sim::DisplayedDepths> depths);

/// Borrows the scene. Drawing thread only.
class Viewport {
 public:
  Viewport(const haptics::TouchScene& scene, vtkRenderWindow* window, bool is_live);

  /// Requests the surface of a version, all of it or where it changed.
  void request_all(const std::shared_ptr<const volume::Version>& version);
  void request(const std::shared_ptr<const volume::Version>& version, const volume::VoxelBox& changed);
  /// Waits until all requested surfaces are finished.
  void wait();
  /// Temporarily shows other shapes of the same scan, such as a threshold during its choice; null: those of
  /// the scene.
  void preview(std::unique_ptr<haptics::TouchScene> shapes,
               const std::shared_ptr<const volume::Version>& version);
  /// Bone, structures and groups of objects, each with its opacity in the picture. Never empty.
  const std::vector<Structure>& structures() const noexcept { return list_; }
  /// Sets the opacity (0 hidden, 1 opaque) of a structure, by its number in the list. If the bone or a
  /// structure is translucent, or the bone is clipped, structures are drawn whole; otherwise only where an
  /// opening shows them. Touch does not change. Live windows only.
  void set_opacity(std::size_t structure, double opacity);
  /// Sets opacities by name. Errors are those of view::set_opacities(). Live windows only.
  Status set_opacities(std::span<const StructureOpacity> opacities);
  void set_clip(const ClipChoice& choice);
  const ClipChoice& clip() const noexcept { return clip_; }
  /// Plane in front of which the picture is clipped; nullopt: no clipping.
  std::optional<volume::Openings::Plane> clip_plane() const;
  /// Distance (mm) along the ray to the face of the bone at the clip plane; nullopt if the ray does not meet
  /// it.
  std::optional<double> distance_to_clip_face(const volume::Version& version, const Ray& ray) const;
  /// Camera of the picture, in its own pixels.
  volume::Camera camera();
  /// Turns the camera about its focal point, in degrees; the patient's head remains up.
  void turn(double left, double up);

  /// Zooms by a factor (above 1: nearer) toward the object at (x, y) (as in ray_at()), never nearer than 20
  /// mm to it.
  void zoom(const volume::Version& version, double factor, double x, double y);

  /// Sets the geometry with which the tool of a hand currently touches.
  void set_contact_tool(const haptics::ToolShape& tool, std::size_t hand = 0);
  /// True if the tool of the first hand is a model.
  bool has_model_tool() const noexcept { return contacts_[0].mesh != nullptr; }
  /// Returns the radius (mm) of the balls of the first hand's geometry; 0: a point, or a shell.
  double touch_radius() const noexcept { return contacts_[0].radius; }
  /// Shows the stylus of a tick for the hand of the record. A stylus without an orientation is tilted by
  /// shaft_direction().
  void show_stylus(const haptics::ServoRecord& record, ToolAppearance tool, const volume::Version& version,
                   const glm::dvec3& toward_viewer);
  /// Direction (unit) of the shaft of a ball on a surface, between the normal and the viewer, so that the
  /// ball is visible.
  static glm::dvec3 shaft_direction(const glm::dvec3& normal, const glm::dvec3& toward_viewer);
  /// Sets a line (world, mm) on the bone that is drawn together with the stylus, such as the edge under which
  /// a tool goes. Empty: no line.
  void mark_line(std::vector<glm::dvec3> line) { edge_ = std::move(line); }
  /// Sets the plan, which is always shown in addition to the bone.
  void set_plan(sim::Overlays plan);
  /// Replaces the overlays that are shown in addition to the plan; `hands`: the newest tick of each.
  void show(std::span<const sim::Overlay> overlays, std::span<const haptics::ServoRecord> hands);
  /// Sets marks of the user, which are drawn in front of everything. Live windows only.
  void set_marks(sim::Overlays marks);
  std::size_t overlay_count() { return view_.overlays().size(); }
  void show_text(const std::string& corner, const std::string& foot) { view_.show_text(corner, foot); }
  /// Draws a whole state without a tool, seen from `from` (unit), aimed between the bone's middle (`share` 0)
  /// and `at` (1). `distance_factor`: camera distance as a share of that which shows the whole bone.
  void show_still(const std::shared_ptr<const volume::Version>& version,
                  std::span<const sim::Overlay> overlays, const glm::dvec3& at, const glm::dvec3& from,
                  double share, double distance_factor);
  /// Returns the direction `out` turned a little to the side and up (unit), so that depth is visible.
  static glm::dvec3 oblique_direction(const glm::dvec3& out);
  /// Returns the direction that is upward in pictures of show_still() from `from` (unit).
  static glm::dvec3 upward_from(const glm::dvec3& from);
  /// Shows all of the bone from one of A P L R S I, or from the front left above (0).
  void look_from(char side) { view_.look_from(side, visible_low_, visible_high_); }
  /// Shows the view of a surgeon who works at a position: from outside, slightly oblique.
  void look_at_work(const glm::dvec3& at_world);
  /// Adopts finished chunks and draws. Returns the duration in ms; nullopt, without drawing, if the picture
  /// would not change.
  std::optional<double> draw();

  /// Ray through the picture at (x, y), shares of its width and height from the lower left.
  Ray ray_at(double x, double y);
  /// Position of a world point in the picture, as in ray_at().
  glm::dvec2 project(const glm::dvec3& at_world);
  enum class Clipping { applied, ignored };
  /// Distance (mm) along the ray to the first solid of any shape, in the part that is not clipped or in all;
  /// negative if the ray meets no solid.
  double distance_to_solid(const volume::Version& version, const Ray& ray,
                           Clipping clipping = Clipping::applied) const;
  /// Index of the touchable shape with a solid voxel at or next to a position; 0, as for the first shape, if
  /// there is no such shape.
  std::size_t shape_near(const glm::dvec3& at_world) const;
  /// Distance (mm) along the ray at which the centre of a ball that moves along it first touches a solid that
  /// distance_to_solid() returns. `hit`: that distance for the ray itself, not negative.
  double distance_to_contact(const volume::Version& version, const Ray& ray, double radius, double hit) const;
  /// Resting position of an idle tool along the ray. Through an opening in the solid as scanned it goes no
  /// farther than the first labelled structure behind it or, without a structure nearby, the far side of the
  /// removed matter; not to the far side of the skull.
  struct RestingPosition {
    double distance = -1;  ///< mm along the ray; negative: the ray meets nothing
    bool is_soft = false;  ///< no touchable solid: a labelled structure, or an opening
  };
  RestingPosition resting_position(const volume::Version& version, const Ray& ray) const;
  /// Mean direction (unit, out of the solid) of the surface within some millimetres around its intersection
  /// with the ray; nullopt if there is too little surface.
  std::optional<glm::dvec3> mean_surface_normal(const volume::Version& version, const Ray& ray) const;
  /// Point above everything, for an idle stylus.
  glm::dvec3 outside_point() const;
  /// Unit normal of the first shape's surface, out of the solid; 0 if the field has no gradient.
  glm::dvec3 normal_at(const volume::Version& version, const glm::dvec3& p_world) const;

  /// Requests the screen depth of scenery in a cube of `edge` mm around `at`, read in the next frame.
  void request_depth(const glm::dvec3& at, double edge);
  /// Returns the requested depth; nullopt if there is no scenery or the depth is not ready.
  std::optional<ScreenDepth::Reading> take_depth();
  BoneView& view() noexcept { return view_; }
  /// Returns the presentation of the picture.
  DisplayMode display() const { return view_.eyes() ? view_.eyes()->mode() : DisplayMode(); }
  std::size_t triangle_count() const { return view_.bone().triangle_count(); }
  bool is_complete() const;
  /// Returns the share of the picture that is drawn at full detail, 0 to 1; 1: complete.
  double drawn_share() const;
  /// Returns true if all requested surfaces are computed. The picture is whole then, and may be coarse.
  bool is_whole() const;
  /// Draws until the picture is complete. Returns false if the window cannot be drawn into.
  bool complete();

 private:
  /// Adopts finished chunks of bone and of opened structures, and finished surfaces of whole structures.
  void fetch_meshes();
  /// Makes the picture follow the opacities of the list.
  void apply_opacities();
  /// True if structures are drawn whole; see set_opacity(). Bone that is hidden as a whole counts as
  /// translucent.
  bool has_whole_structures() const;
  bool has_translucent_single_bone() const;
  /// Requests the whole surface of a structure if the picture shows it and `version` is not that of its mesh.
  void request_whole(std::size_t structure, const std::shared_ptr<const volume::Version>& version);
  /// Calls visit(distance along the ray in mm, voxel, is_solid_as_scanned, is_solid_now) along the ray behind
  /// the clip plane, while it returns true.
  template <class Visit>
  void follow(const volume::Version& version, const Ray& ray, const Visit& visit,
              Clipping clipping = Clipping::applied) const;
  void request_cap();
  bool is_clipped_in(const volume::VoxelBox& voxels) const;
  void show_in_front();
  sim::Overlays plan_;
  sim::Overlays marks_, in_front_;  ///< `in_front_`: overlays of the last show() that bone does not hide
  std::shared_ptr<const volume::Version> version_;  ///< version of the last request
  std::shared_ptr<const volume::Version> uncut_;    ///< the scan without cuts
  std::vector<glm::dvec3> edge_;
  const haptics::TouchScene* scene_;
  vtkRenderWindow* window_;
  bool is_live_;
  BoneView view_;
  std::unique_ptr<haptics::TouchScene> preview_;
  std::unique_ptr<ChunkWorker> worker_;
  std::unique_ptr<OpenedStructures> opened_;
  std::vector<int> opened_labels_;  ///< those that `opened_` draws
  std::vector<Structure> list_;
  StructureSurfaces surfaces_;
  SectionCap cap_;
  bool is_cap_moved_ = false;          ///< the plane changed, or what it cuts became visible or hidden
  bool are_structures_whole_ = false;  ///< as has_whole_structures() when opacities were applied
  std::map<int, std::uint64_t> whole_versions_;  ///< serial of the version of each whole mesh, by label
  ClipChoice clip_;
  /// Contact geometry of the tool of a hand.
  struct Contact {
    double radius = 0;  ///< mm, as touch_radius()
    bool is_rigid =
        false;  ///< the tool touches with six degrees of freedom; its orientation is that of the hand
    std::shared_ptr<const haptics::MeshTree> mesh = nullptr;  ///< surface of the tool; null: none
    std::vector<glm::dvec2> profile = {};                     ///< of a body of revolution: along, radius
    static Contact of(const haptics::ToolShape& tool);
  };
  std::vector<Contact> contacts_;                    ///< by hand
  glm::dvec3 low_{0.0}, high_{0.0};                  ///< world box of the solid voxels
  glm::dvec3 visible_low_{0.0}, visible_high_{0.0};  ///< world box of solid voxels and models
  glm::dvec3 clip_origin_{0.0}, clip_normal_{0.0};
};

}  // namespace trephine::view
