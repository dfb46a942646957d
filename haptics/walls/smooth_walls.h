// SmoothWalls: smooth solids of a scene during one servo step: exact crossings of a motion with them, and the
// walls at a point.
#pragma once

#include <algorithm>
#include <array>
#include <glm/common.hpp>
#include <span>
#include <utility>

#include "haptics/proxy/proxy_step.h"
#include "haptics/scene/touch_state.h"
#include "volume/fields/quadratic_patch.h"
#include "volume/scan/traversal.h"

namespace trephine::haptics {

/// A smooth function that the proxy must keep below 0: the field of a shape, the distance to removed matter,
/// or the negative of one of these.
struct Wall {
  int shape = -1;
  bool is_cut = false;      ///< true: the distance to removed matter; false: the field of the scan
  bool is_back = false;     ///< keeps the proxy inside: the function is minus the field
  std::uint32_t facet = 0;  ///< of a mesh
  int sheet = -1;           ///< of a creased cube (volume/fields/crease_sheets.h); -1: the field itself
  /// Cube whose polynomial the wall uses in creased cubes that lack `sheet`; if is_step, in all cubes.
  glm::ivec3 cube{0};
  bool is_step = false;  ///< the solid ends in a step at a face of `cube`, which stopped a motion
  friend bool operator==(const Wall& a, const Wall& b) noexcept {
    return a.shape == b.shape && a.is_cut == b.is_cut && a.is_back == b.is_back && a.facet == b.facet &&
           a.sheet == b.sheet && a.is_step == b.is_step && (!a.is_step || a.cube == b.cube);
  }
};

/// Free part of a motion.
struct Reach {
  double t = 1;  ///< [0, t] of the motion is free; 1 if the motion is not blocked
  bool is_blocked = false;
  Wall wall;  ///< the blocking wall
};

/// Borrows scene, state and counters for one step. For a tool with a radius, points are positions of the
/// tool's centre, and the offset fields determine the solids (volume/fields/offset_field.h). For a point
/// tool, a point is solid for a shape if g >= 0 and d >= 0, where g is the smooth reconstruction
/// (volume/fields/quadratic_patch.h) of the shape's field, and d that of the distance to removed matter.
/// Polynomials are cached for the few cubes that a step meets. Servo thread: no allocation, every loop
/// bounded.
class SmoothWalls {
 public:
  /// For the shapes of the base.
  SmoothWalls(const TouchScene& scene, const TouchState& touch_state, const ShapeSet& passable,
              ProxyCounters& counters) noexcept
      : SmoothWalls(scene, touch_state, passable, counters, 0, static_cast<int>(base_shapes(scene).size()),
                    nullptr) {}
  /// For the shapes begin .. end - 1, which must belong to the version's volume. If `near` is not null, only
  /// those of them in `near` are tested.
  SmoothWalls(const TouchScene& scene, const TouchState& touch_state, const ShapeSet& passable,
              ProxyCounters& counters, int begin, int end, const ShapeSet* near) noexcept
      : scene_(&scene),
        volume_(&touch_state.version->base()),
        touch_state_(&touch_state),
        version_(touch_state.version.get()),
        passable_(&passable),
        counters_(&counters),
        near_(near),
        begin_(begin),
        end_(end),
        is_round_(scene.tool->radius() > 0 && begin < end),
        is_cut_(!is_round_ && !version_->is_uncut()),
        is_fine_(!version_->lattice().has_voxel_resolution()) {}

  /// Uses a larger cache, for a step that meets hundreds of cubes. Several SmoothWalls may share a cache if
  /// they have no shape in common.
  struct LargeCache;
  void use(LargeCache& cache) noexcept { large_ = &cache; }

  /// Returns the frame of all points: the volume's, or that of the offset fields if the tool has a radius.
  const volume::Frame& frame() const noexcept {
    return is_round_ ? scene_->items[static_cast<std::size_t>(begin_)].offset->frame() : volume_->frame;
  }

  /// Returns the first shape from `s` on; ShapeSet::k_max after the last.
  int next_shape(int s) const noexcept {
    if (near_) s = near_->next(s < begin_ ? begin_ : s);
    return s < end_ ? s : ShapeSet::k_max;
  }
  bool blocks(int shape, Side side) const noexcept {
    return haptics::blocks(*scene_, *passable_, shape, side);
  }

  /// Returns true if the shape may have a wall for a proxy that is inside or outside of its solid.
  bool may_block(int shape, bool is_inside) const noexcept { return blocks(shape, side_of(is_inside)); }

  /// Returns the free part of the motion from a toward b. Bounds on the polynomials of every cube that the
  /// motion meets prove that this part is free, so that no solid is missed, however thin it is. Stops within
  /// `tolerance` mm before the first wall, or where a proof would take too long. `inside`: the solids that
  /// contain the start a, updated where a shape lets the motion pass.
  Reach reach(const glm::dvec3& a, const glm::dvec3& b, ShapeSet& inside, double tolerance) noexcept;

  /// Returns true if it is proven that there is no matter of the shape within `steps` planes of voxels of p,
  /// or that p is at least `mm` deep in removed matter. Also returns true if the front of the shape does not
  /// block. False does not mean that there is matter. For point tools only.
  bool is_free_within(int shape, const glm::dvec3& p, double steps, double mm) const noexcept;
  /// Returns true if the occupancy proves that the uncut shape has no smooth solid within `steps` planes of
  /// voxels of p. Finer than is_free_within(); cost: (2 steps + 5)^2 rows of voxels. For point tools only.
  bool is_air_within(int shape, const glm::dvec3& p, double steps) const noexcept;
  /// Returns true if p is in the solid of the shape.
  bool is_solid(int shape, const glm::dvec3& p) noexcept;
  /// Returns the derivatives of a wall's function at p; its value is negative in free space.
  volume::Jet jet(const Wall& wall, const glm::dvec3& p) noexcept;
  volume::ValueAndGradient value_and_gradient(const Wall& wall, const glm::dvec3& p) noexcept;
  /// Two points, which stand for the cubes in their bounding box: voxels, or for a cut the cubes of samples.
  struct Span {
    glm::dvec3 a, b;
    Span(const glm::dvec3& from, const glm::dvec3& to) noexcept : a(from), b(to) {}
  };
  /// Returns a bound of |second derivative| of the wall's function over the cubes of a span. If there are
  /// more than `most` cubes, the bound holds only in the cubes of the two ends, and `is_whole` is false.
  volume::QuadraticPatch::HessianBound hessian_bound(const Wall& wall, const Span& span, bool& is_whole,
                                                     int most = k_few_cubes) noexcept;
  static constexpr int k_few_cubes = 4;
  /// Extends a bound of hessian_bound() to the bounding box of the span and m.
  void widen(const Wall& wall, const Span& span, const glm::dvec3& m,
             volume::QuadraticPatch::HessianBound& bound, bool& is_whole) noexcept;
  /// Returns the longest leg (mm) over which the wall's function can be followed. For a cut, the leg is
  /// limited, because the distance to removed matter is constant beyond the band.
  double longest_leg(const Wall& wall, double usual) const noexcept {
    constexpr double k_bands = 2.2;
    return wall.is_cut ? std::min(usual, k_bands * version_->band_mm()) : usual;
  }
  /// Returns the spacing (mm) of the samples of a wall's function: voxels, or for a cut those of its finer
  /// lattice.
  double sample_mm(const Wall& wall) const noexcept {
    const glm::dvec3& mm = wall.is_cut ? version_->lattice().frame().spacing() : frame().spacing();
    return std::min({mm.x, mm.y, mm.z});
  }
  /// Returns true if no other wall blocks a motion that this wall leaves free: there is one shape, touched
  /// from outside, and the wall is neither a sheet nor a step.
  bool is_only_wall(const Wall& wall) const noexcept {
    return end_ - begin_ == 1 && !wall.is_back && wall.sheet < 0 && !wall.is_step;
  }
  /// Returns true if one of the cubes around p is creased. In creased cubes each flank has its own wall.
  bool is_near_crease(int shape, const glm::dvec3& p) const noexcept;
  /// Returns true if the cube of voxel v may contain a cut.
  bool is_near_cut(const glm::ivec3& v) const noexcept;

  /// Returns a point next to p, away from the walls with these unit normals (into the solid), at which a wall
  /// that is a step does not block; p if there is no such point near it. Adds to `is_kept` the axes
  /// perpendicular to the faces between p and the step; along these axes the point has the coordinates of p.
  glm::dvec3 above_step(const Wall& wall, const glm::dvec3& p, std::span<const glm::dvec3> normals_world,
                        glm::bvec3& is_kept) noexcept;

  /// Finds the walls of one shape on which p may rest, and returns their number. If the shape is in `inside`,
  /// these are field and cut. Else it is the one of them that leaves more room, or in a creased cube the
  /// sheets nearest to p. Returns 0 if is_covered() holds at p. Ignores `within`, which SceneWalls uses for
  /// meshes.
  using WallList = std::array<Wall, 4>;
  int walls_at(int shape, const ShapeSet& inside, const glm::dvec3& p, double within,
               WallList& walls) noexcept;

 private:
  struct Cached {
    volume::QuadraticPatch patch;
    volume::QuadraticPatch::HessianBound hessian_bound;
    glm::ivec3 voxel;  ///< for a cut the sample of its lattice
    int key;           ///< k_cut, or shape and sheet as in patch_of()
    bool has_hessian_bound;
  };
  static constexpr int k_cut = 1000, k_cached = 8, k_sheet_shift = 16;

  const volume::OffsetField& offset(std::size_t shape) const noexcept {
    return touch_state_->offset(*scene_, shape);
  }
  glm::ivec3 grid_size() const noexcept {
    return is_round_ ? offset(static_cast<std::size_t>(begin_)).size() : volume_->size;
  }
  Cached& patch(int key, const glm::ivec3& v) noexcept;
  /// Returns the sheets (a bit each) of the cube of v; 0 if it is not creased.
  volume::CreaseSheets::Mask sheets_at(int shape, const glm::ivec3& v) const noexcept {
    return is_round_ ? offset(static_cast<std::size_t>(shape)).sheets_at(v) : 0;
  }
  /// Returns the patch of a wall for points in the cube `at`. Not for a wall of a cut.
  Cached& patch_of(const Wall& wall, const glm::ivec3& at) noexcept {
    volume::CreaseSheets::Mask sheets = wall.sheet < 0 ? 0 : sheets_at(wall.shape, at);
    glm::ivec3 v = at;
    if (wall.is_step || (sheets != 0 && (sheets >> wall.sheet & 1) == 0)) {
      v = wall.cube;
      sheets = wall.sheet < 0 ? 0 : sheets_at(wall.shape, v);
    }
    return patch(sheets != 0 ? wall.shape | (wall.sheet + 1) << k_sheet_shift : wall.shape, v);
  }
  /// Returns bounds per step of frame(). The patch of a cut is per step of the cut lattice, so its bounds are
  /// converted.
  const volume::QuadraticPatch::HessianBound& hessian_bound_of(Cached& cached) const noexcept;
  /// Returns value and derivatives of the cut, per voxel step, from the patch around a sample.
  volume::ValueAndGradient cut_value_and_gradient(const volume::CutLattice::Point& at) noexcept;
  using CubeSpan = std::pair<glm::ivec3, glm::ivec3>;
  CubeSpan cubes_of(const Wall& wall, const glm::dvec3& a, const glm::dvec3& b) const noexcept;
  volume::QuadraticPatch::HessianBound bound_over(const Wall& wall, const CubeSpan& cubes, bool& is_whole,
                                                  int most = k_few_cubes) noexcept;
  /// Returns the distance in blocks of four voxels to the nearest block that may contain matter of the shape,
  /// as chessboard distance.
  int empty_distance(int shape, const glm::ivec3& v) const noexcept;
  /// Returns true if there is no matter within one voxel of v, of the shape or of its extension into others.
  bool is_air_around(int shape, const glm::ivec3& v) const noexcept;
  /// Finds the sheets of a creased cube that are nearest to p, and differ in direction.
  int sheets_near(int shape, volume::CreaseSheets::Mask sheets, const glm::dvec3& p,
                  WallList& walls) noexcept;
  /// A motion a + t along, t in [0, 1], and the step of t below which a proof ends.
  struct Leg {
    const glm::dvec3 &a, &along;
    double min_step;
  };
  /// Tests one shape over [t0, t1] of the leg, all in cube v. Returns the end of the free part: t1, or less
  /// at `blocker`.
  double reach_in_cube(int shape, bool is_inside, const glm::ivec3& v, const Leg& leg, double t0, double t1,
                       Wall& blocker) noexcept;
  /// As reach_in_cube(), for a part of the leg on which the cut has one polynomial: that of `sample` (null:
  /// no cut).
  double reach_in_piece(const Wall& field, const glm::ivec3& v, const glm::ivec3* sample, const Leg& leg,
                        double t0, double t1, Wall& blocker) noexcept;
  /// Returns true if, near a cut, another blocking shape fills the cube of v. Then only the cut bounds the
  /// matter, and the walls of the other shape include the cut. If both shapes fill the cube, the first one
  /// keeps its walls. Without this test, a tool in a hole would touch the end of a soft shape that extends
  /// into its neighbour.
  bool is_covered(int shape, const ShapeSet& inside, const glm::ivec3& v) noexcept;
  /// Follows a shape that does not block: updates `inside` at the first point where the motion passes its
  /// surface, and sets `t_changed` to the parameter of this point; to t1 without such a point.
  void pass(int shape, const glm::ivec3& v, const glm::dvec3& a, const glm::dvec3& along, double t0,
            double t1, ShapeSet& inside, double& t_changed) noexcept;

  const TouchScene* scene_;
  const volume::Volume* volume_;
  const TouchState* touch_state_;
  const volume::Version* version_;  ///< of `touch_state_`
  const ShapeSet* passable_;
  ProxyCounters* counters_;
  const ShapeSet* near_;
  int begin_, end_;  ///< the tested shapes are begin_ .. end_ - 1
  bool is_round_, is_cut_;
  bool is_fine_;  ///< the lattice of cuts is finer than the voxels
  std::array<Cached, k_cached> cache_;
  int next_ = 0, count_ = 0;
  LargeCache* large_ = nullptr;
};

/// Cache of polynomials. The cube determines the slot; polynomials of cuts have separate slots.
struct SmoothWalls::LargeCache {
  static constexpr std::size_t k_slots = 256;  ///< number of slots of fields, and also of cuts
  std::array<Cached, 2 * k_slots> all;         ///< not initialized
  std::array<bool, 2 * k_slots> is_used{};
  LargeCache() noexcept {}
};

/// Turns a direction away from all walls, as far as possible. `normals`: unit normals of the walls, into the
/// solid.
glm::dvec3 turned_away(glm::dvec3 direction, std::span<const glm::dvec3> normals) noexcept;
/// Returns the longest step tau with c + c' tau + c'' tau^2 / 2 <= 0: the distance over which a function with
/// the value c stays at most 0. c' is `derivative`, c'' is `second_derivative`. Requires c < 0 and c'' >= 0.
double free_step(double c, double derivative, double second_derivative) noexcept;
/// Returns a bound of the rounding error of a patch's value.
double rounding_of(const volume::ValueAndGradient& field,
                   const volume::QuadraticPatch::HessianBound& hessian) noexcept;

}  // namespace trephine::haptics
