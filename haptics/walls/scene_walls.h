// SceneWalls: walls of a whole scene during one servo step: the smooth solids of several volumes and the
// facets of polygonal models. All walls are in one frame, so that Slide handles them together.
#pragma once

#include <array>
#include <type_traits>
#include <vector>

#include "haptics/mesh/mesh_tree.h"
#include "haptics/walls/smooth_walls.h"

namespace trephine::haptics {

/// Data of a scene that do not change from step to step. Made once, not on the servo thread.
class SceneLayout {
 public:
  static constexpr int k_max_volumes = 8;
  struct Part {
    int begin, end;                           ///< its shapes: begin .. end - 1
    std::shared_ptr<const TouchState> uncut;  ///< null for the base, which has the state of the step
    const volume::Frame* frame;               ///< of the volume's walls
    glm::dmat3 from_scene;                    ///< maps displacements of the scene's frame to `frame`
    double plane_distance;                    ///< mm, least distance between adjacent planes of voxels
  };
  struct Box {
    glm::dvec3 low, high;  ///< mm; world frame, or for a moving mesh the frame of the mesh
  };

  /// Error if the shapes of a volume are not consecutive items, or volumes, shapes or movers are too many.
  static Result<SceneLayout> of(const TouchScene& scene);

  /// Returns an axis-aligned frame with the finest voxel spacing of all volumes as its step. Without volumes
  /// the step is 0.5 mm, or less for a tiny model.
  const volume::Frame& frame() const noexcept { return frame_; }
  const std::vector<Part>& parts() const noexcept { return parts_; }
  double sample_mm() const noexcept { return sample_mm_; }
  /// Returns the mesh of each mover, as an index of TouchScene::items; -1: no mesh.
  const std::array<int, TouchScene::k_max_movers>& movers() const noexcept { return movers_; }
  /// Returns the current placement of the mesh of each mover. For an item touched by depth images, the
  /// placement includes the motion extrapolated from its images.
  std::array<Placement, TouchScene::k_max_movers> placements_of(const TouchScene& scene,
                                                                const TouchState& touch_state,
                                                                const ProxyInput& input) const noexcept;
  /// Adopts new depth images: converts the previous placements in `around`, so that they refer to the new
  /// images. Returns the items with new images. Call first in a step, while `around` has the data of the
  /// previous step.
  ShapeSet adopt_sets(const TouchScene& scene, const TouchState& touch_state, const ProxyInput& input,
                      Surroundings& around) const noexcept;
  /// Returns the placement that was set for a mesh, without the motion extrapolated from depth images.
  static const Placement& given_placement(const TouchItem& mesh, const ProxyInput& input) noexcept;
  /// Returns the index of an item among those touched by depth images; -1: not touched by images.
  int depth_index(int shape) const noexcept { return depth_of_[static_cast<std::size_t>(shape)]; }
  /// Returns the items touched by depth images.
  const std::vector<int>& depths() const noexcept { return depths_; }
  const Box& box(int shape) const noexcept { return boxes_[static_cast<std::size_t>(shape)]; }

 private:
  Status add_voxels(const TouchScene& scene, int index);
  Status add_mesh(const TouchItem& mesh, int index);

  volume::Frame frame_;
  double sample_mm_ = 1e300;
  std::vector<Part> parts_;
  std::vector<Box> boxes_;
  std::array<int, TouchScene::k_max_movers> movers_;
  std::vector<int> depths_, depth_of_;
};

/// Implements the walls of Slide. Borrows its arguments for one step. Tests only the shapes in
/// Surroundings::nearby; the caller ensures that the motion cannot meet other shapes. Servo thread: no
/// allocation, every loop bounded.
class SceneWalls {
 public:
  SceneWalls(const TouchScene& scene, const SceneLayout& layout, const TouchState& touch_state,
             const ProxyState& state, std::span<const Placement> placements,
             ProxyCounters& counters) noexcept;

  /// Uses a larger cache, for a step that meets hundreds of cubes. Call before all other methods.
  void use(SmoothWalls::LargeCache& cache) noexcept { large_ = &cache; }
  const volume::Frame& frame() const noexcept { return layout_.frame(); }
  int next_shape(int s) const noexcept { return state_.around.nearby.next(s); }
  bool blocks(int shape, Side side) const noexcept {
    return haptics::blocks(scene_, state_.around.passable, shape, side);
  }
  /// As in SmoothWalls. A mesh may always block: it has no inside, and each facet is tested on its own sides.
  bool may_block(int shape, bool is_inside) const noexcept {
    return is_mesh(shape) || blocks(shape, side_of(is_inside));
  }
  /// As SmoothWalls::reach(). `skipped`: a mesh that is not tested. `latest`: share of the motion, 0 to 1;
  /// hits of meshes after it may be missed.
  Reach reach(const glm::dvec3& a, const glm::dvec3& b, ShapeSet& inside, double tolerance, int skipped = -1,
              double latest = 1) noexcept;
  /// Returns true if there is no matter of the shape, and no facet, within `mm` of p. Conservative: false
  /// does not mean that there is matter. For tools without a radius.
  bool is_free_within(int shape, const glm::dvec3& p, double mm) noexcept;
  /// As reach(), for one mesh only.
  Reach reach_model(int mesh, const glm::dvec3& a, const glm::dvec3& b, double tolerance,
                    double latest) noexcept {
    Reach reach;
    reach_mesh(mesh, a, b, tolerance, latest, reach);
    return reach;
  }
  bool is_solid(int shape, const glm::dvec3& p) noexcept;
  volume::Jet jet(const Wall& wall, const glm::dvec3& p) noexcept;
  volume::ValueAndGradient value_and_gradient(const Wall& wall, const glm::dvec3& p) noexcept;
  /// Two points. Unlike SmoothWalls::Span it does not store cubes, because volumes have different voxels.
  struct Span {
    const glm::dvec3 &a, &b;
    Span(const glm::dvec3& from, const glm::dvec3& to) noexcept : a(from), b(to) {}
  };
  volume::QuadraticPatch::HessianBound hessian_bound(const Wall& wall, const Span& span, bool& is_whole,
                                                     int most = SmoothWalls::k_few_cubes) noexcept;
  /// Returns a bound that holds within `reach` (steps of the scene's frame) of p along each axis.
  volume::QuadraticPatch::HessianBound hessian_bound_around(const Wall& wall, const glm::dvec3& p,
                                                            double reach, bool& is_whole, int most) noexcept;
  bool is_only_wall(const Wall&) const noexcept { return false; }
  double longest_leg(const Wall& wall, double usual) noexcept {
    return is_mesh(wall.shape) ? usual : walls_of(part_of(wall.shape)).longest_leg(wall, usual);
  }
  /// Returns the smallest distance (mm) between samples of any volume or its cuts, along the axes of the
  /// scene.
  double sample_mm() const noexcept { return layout_.sample_mm(); }
  double sample_mm(const Wall& wall) noexcept { return walls_of(part_of(wall.shape)).sample_mm(wall); }
  void widen(const Wall&, const Span&, const glm::dvec3&, volume::QuadraticPatch::HessianBound&,
             bool&) const noexcept {}
  /// As in SmoothWalls; returns p for a mesh.
  glm::dvec3 above_step(const Wall& wall, const glm::dvec3& p, std::span<const glm::dvec3> normals_world,
                        glm::bvec3& is_kept) noexcept;
  bool is_near_crease(int shape, const glm::dvec3& p) noexcept;
  using WallList = std::array<Wall, 4>;
  /// Input and output of walls_at() for a mesh and a point.
  struct NearFacets {
    /// Input: all facets within `within` mm of the point, and others; empty pointer: searched in the tree.
    std::span<const MeshTree::Facet> candidates;
    /// Output: true if a motion within `within` mm of the point that stays in front of the planes of the
    /// returned facets is free of the mesh.
    bool is_complete = false;
  };
  /// Finds the walls of a shape at p. For a mesh: the facets within `within` mm of the tool, except those
  /// behind others.
  int walls_at(int shape, const ShapeSet& inside, const glm::dvec3& p, double within, WallList& walls,
               NearFacets* near_facets = nullptr) noexcept;
  /// Finds the facets of a mesh within `mm` of p that a tool may touch, among the candidates or, without
  /// candidates, in the tree; of candidates, also some that are farther. Returns their number, as
  /// MeshTree::find_near().
  std::size_t find_facets(int mesh, const glm::dvec3& p, double mm, std::span<MeshTree::Facet> facets,
                          std::span<const MeshTree::Facet> candidates) const noexcept;

  /// Returns the position of p in the frame of a mesh, mm.
  glm::dvec3 in_mesh(int mesh, const glm::dvec3& p) const noexcept {
    return placement_of(mesh).local_from_world(frame().world_from_volume(p));
  }

  const Placement& placement_of(int mesh_shape) const noexcept;
  /// Returns the triangles of a mesh. For an item touched by depth images, these are the triangles of its
  /// current set, or an empty tree without a set.
  const MeshTree& tree_of(int mesh) const noexcept;
  bool is_mesh(int shape) const noexcept { return item_of(scene_, shape).is_mesh(); }

 private:
  int part_of(int shape) const noexcept;
  volume::QuadraticPatch::HessianBound in_scene_frame(const volume::QuadraticPatch::HessianBound& own,
                                                      int part) const noexcept;
  const SceneLayout::Part& part(int i) const noexcept { return layout_.parts()[static_cast<std::size_t>(i)]; }
  /// Makes the walls on first use.
  SmoothWalls& walls_of(int part) noexcept;
  glm::dvec3 in_part(int i, const glm::dvec3& p) const noexcept {
    return part(i).frame->volume_from_world(frame().world_from_volume(p));
  }
  bool reach_mesh(int shape, const glm::dvec3& a, const glm::dvec3& b, double tolerance, double latest,
                  Reach& reach) noexcept;

  const TouchScene& scene_;
  const SceneLayout& layout_;
  const TouchState& touch_state_;
  const ProxyState& state_;
  std::span<const Placement> placements_;
  ProxyCounters& counters_;
  /// Storage that walls_of() initializes on first use. A std::optional would clear 18 kB in every step.
  union WallsStorage {
    SmoothWalls walls;
    WallsStorage() noexcept {}
  };
  static_assert(std::is_trivially_destructible_v<SmoothWalls>);
  std::array<WallsStorage, SceneLayout::k_max_volumes> walls_;
  std::array<bool, SceneLayout::k_max_volumes> is_constructed_{};
  SmoothWalls::LargeCache* large_ = nullptr;
};

}  // namespace trephine::haptics
