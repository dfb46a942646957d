// The smooth solids of a scene, one servo step long: exact crossings of a way with them, and the walls at a
// point.
#pragma once

#include <algorithm>
#include <array>
#include <glm/common.hpp>
#include <utility>

#include "haptics/proxy/proxy_method.h"
#include "volume/quadratic_patch.h"
#include "volume/traversal.h"

namespace trephine::haptics {

/// A smooth function that the proxy must keep below 0: a shape's field, its cut, or one of them turned round.
struct Wall {
  int shape = -1;
  bool is_cut = false;      ///< the distance to what was removed; else the field of the scan
  bool is_back = false;     ///< holds the proxy inside: the function is minus the field
  std::uint32_t facet = 0;  ///< of a mesh
  friend bool operator==(const Wall&, const Wall&) = default;
};

/// Free part of a way.
struct Reach {
  double t = 1;  ///< [0, t] is free; 1 when nothing is in the way
  bool is_blocked = false;
  Wall wall;  ///< what blocks
};

/// Borrows scene, version and counters for one step. For a tool with a radius the points are those of its
/// middle, and the solid is where its offset field says so (volume/offset_field.h). For a point tool a point
/// is solid for a shape where the smooth reconstructions (volume/quadratic_patch.h) say g >= 0 and d >= 0.
/// Polynomials are kept for the few cubes that a step meets. Servo thread: no allocation, every loop bounded.
class SmoothWalls {
 public:
  /// For the base's shapes.
  SmoothWalls(const TouchScene& scene, const TouchState& seen, const ShapeSet& let_through,
              ProxyCounters& counters) noexcept
      : SmoothWalls(scene, seen, let_through, counters, 0, static_cast<int>(base_shapes(scene).size()),
                    nullptr) {}
  /// For the shapes begin .. end - 1 alone, all of the version's volume, and of them only the ones in `near`
  /// (null: all).
  SmoothWalls(const TouchScene& scene, const TouchState& seen, const ShapeSet& let_through,
              ProxyCounters& counters, int begin, int end, const ShapeSet* near) noexcept
      : scene_(&scene),
        volume_(&seen.version->base()),
        seen_(&seen),
        version_(seen.version.get()),
        let_through_(&let_through),
        counters_(&counters),
        near_(near),
        begin_(begin),
        end_(end),
        is_round_(scene.tool_radius > 0 && begin < end),
        is_cut_(!is_round_ && !version_->is_untouched()),
        is_fine_(!version_->lattice().is_of_voxels()) {}

  /// The frame that all points are in: the volume's, or that of the offset fields where the tool has a
  /// radius.
  const volume::Frame& frame() const noexcept {
    return is_round_ ? scene_->items[static_cast<std::size_t>(begin_)].offset->frame() : volume_->frame;
  }

  /// The first shape from `s` on; ShapeSet::k_most after the last.
  int next_shape(int s) const noexcept {
    if (near_) s = near_->next(s < begin_ ? begin_ : s);
    return s < end_ ? s : ShapeSet::k_most;
  }
  bool holds(int shape, Side side) const noexcept {
    return haptics::holds(*scene_, *let_through_, shape, side);
  }

  /// May the shape have a wall for a proxy inside or outside of it?
  bool may_hold(int shape, bool is_inside) const noexcept { return holds(shape, side_of(is_inside)); }

  /// Free part of the way from a toward b (volume frame): proven by bounds on the polynomials of every
  /// cube that the way meets, so that no solid however thin is passed. Stops within `tolerance` mm before
  /// the first wall, or where a proof would take too long. `inside` says in which solids the way runs, and is
  /// brought up to date where a shape lets it pass.
  Reach reach(const glm::dvec3& a, const glm::dvec3& b, ShapeSet& inside, double tolerance) noexcept;

  /// Is p in the solid of the shape?
  bool is_solid(int shape, const glm::dvec3& p) noexcept;
  /// Derivatives of a wall's function at p; its value is negative where it is free.
  volume::Jet jet(const Wall& wall, const glm::dvec3& p) noexcept;
  volume::ValueAndGradient value_and_gradient(const Wall& wall, const glm::dvec3& p) noexcept;
  /// The cubes of the box of two points: voxels, and where a cut is asked about its samples.
  struct Span {
    glm::dvec3 a, b;
    Span(const glm::dvec3& from, const glm::dvec3& to) noexcept : a(from), b(to) {}
  };
  /// Bound of |second derivative| of the wall's function over the cubes of a span; over its two ends alone,
  /// and not `is_whole`, where it holds more than four.
  volume::QuadraticPatch::HessianBound hessian_bound(const Wall& wall, const Span& span,
                                                     bool& is_whole) noexcept;
  /// Makes such a bound one over the box of the span and m.
  void widen(const Wall& wall, const Span& span, const glm::dvec3& m,
             volume::QuadraticPatch::HessianBound& bound, bool& is_whole) noexcept;
  /// The longest leg (mm) along a wall that its function can be followed over: beyond its band a cut's
  /// distance is flat.
  double longest_leg(const Wall& wall, double usual) const noexcept {
    constexpr double k_bands = 2.2;
    return wall.is_cut ? std::min(usual, k_bands * version_->band_mm()) : usual;
  }
  /// mm between the samples of a wall's function: voxels, or where it is a cut those of its finer lattice.
  double sample_mm(const Wall& wall) const noexcept {
    const glm::dvec3& mm = wall.is_cut ? version_->lattice().frame().spacing() : frame().spacing();
    return std::min({mm.x, mm.y, mm.z});
  }
  /// Would this wall alone, kept, leave every way free that it leaves free? So where one shape is touched
  /// from outside.
  bool is_only_wall(const Wall& wall) const noexcept { return end_ - begin_ == 1 && !wall.is_back; }
  /// May the cube of voxel v hold something cut?
  bool is_near_cut(const glm::ivec3& v) const noexcept;

  /// The walls of one shape on which p, on the side `is_inside`, may rest: the most free one from outside,
  /// field and cut from inside. Returns how many; `within` is for walls of other kinds.
  using WallList = std::array<Wall, 2>;
  int walls_at(int shape, const ShapeSet& inside, const glm::dvec3& p, double within,
               WallList& walls) noexcept;

 private:
  struct Cached {
    volume::QuadraticPatch patch;
    volume::QuadraticPatch::HessianBound hessian_bound;
    glm::ivec3 voxel;  ///< of a cut the sample
    int key;           ///< shape, or k_cut
    bool has_hessian_bound;
  };
  static constexpr int k_cut = 1000, k_kept = 6;

  const volume::OffsetField& offset(std::size_t shape) const noexcept {
    return seen_->offset(*scene_, shape);
  }
  glm::ivec3 grid_size() const noexcept {
    return is_round_ ? offset(static_cast<std::size_t>(begin_)).size() : volume_->size;
  }
  Cached& patch(int key, const glm::ivec3& v) noexcept;
  /// Bounds in the frame of all points, also of a cut's patch, which is per lattice step.
  const volume::QuadraticPatch::HessianBound& hessian_bound_of(Cached& kept) const noexcept;
  /// Value and derivatives of the cut, per voxel step, from the patch around a sample.
  volume::ValueAndGradient cut_value_and_gradient(const volume::CutLattice::Point& at) noexcept;
  using CubeSpan = std::pair<glm::ivec3, glm::ivec3>;
  CubeSpan cubes_of(const Wall& wall, const glm::dvec3& a, const glm::dvec3& b) const noexcept;
  volume::QuadraticPatch::HessianBound bound_over(const Wall& wall, const CubeSpan& cubes,
                                                  bool& is_whole) noexcept;
  /// Blocks of four voxels to the nearest one that may hold matter of the shape, by a chessboard's distance.
  int empty_distance(int shape, const glm::ivec3& v) const noexcept;
  /// Is there no matter within one voxel of v, of the shape or of what it goes on into?
  bool is_air_around(int shape, const glm::ivec3& v) const noexcept;
  /// A way a + t along, and the steps of t below which nothing is proven.
  struct Way {
    const glm::dvec3 &a, &along;
    double least_step;
  };
  /// One shape over [t0, t1] of the way, all in cube v. Returns how far it is free: t1, or less where
  /// `blocker` is.
  double reach_in_cube(int shape, bool is_inside, const glm::ivec3& v, const Way& way, double t0, double t1,
                       Wall& blocker) noexcept;
  /// Free part where the cut, if there is one, has one polynomial: all in the cube of `sample`.
  double reach_in_piece(int shape, bool is_inside, const glm::ivec3& v, const glm::ivec3* sample,
                        const Way& way, double t0, double t1, Wall& blocker) noexcept;
  /// Near a cut, is everything of the shape in the cube of v also matter of another one that holds there?
  /// Then the cut alone bounds both, and the walls of the other one do. So where a soft shape goes on into
  /// its neighbour and ends there, which a tool in a hole would meet.
  bool is_covered(int shape, const ShapeSet& inside, const glm::ivec3& v) noexcept;
  /// Follows a shape that does not hold: changes `inside` where the way passes its surface.
  void pass(int shape, const glm::ivec3& v, const glm::dvec3& a, const glm::dvec3& along, double t0,
            double t1, ShapeSet& inside, double& t_changed) noexcept;

  const TouchScene* scene_;
  const volume::Volume* volume_;
  const TouchState* seen_;
  const volume::Version* version_;  ///< its own
  const ShapeSet* let_through_;
  ProxyCounters* counters_;
  const ShapeSet* near_;
  int begin_, end_;  ///< of its shapes
  bool is_round_, is_cut_;
  bool is_fine_;  ///< the lattice of cuts is finer than the voxels
  std::array<Cached, k_kept> kept_;
  int next_ = 0, count_ = 0;
};

/// The longest step tau with c + c' tau + c'' tau^2 / 2 <= 0 for c < 0, c'' >= 0: how far a value that
/// is c here stays negative.
double free_step(double c, double derivative, double second_derivative) noexcept;
/// Bound of the rounding error of a patch's value.
double rounding_of(const volume::ValueAndGradient& field,
                   const volume::QuadraticPatch::HessianBound& hessian) noexcept;

}  // namespace trephine::haptics
