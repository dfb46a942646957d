// DepthSource: object that can be drawn, and is touched by depth images of its surface around a hand. When
// the object changes, the images are drawn again.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <memory>

#include "haptics/depth/depth_net.h"
#include "haptics/mesh/mesh_tree.h"
#include "haptics/scene/touch_state.h"

namespace trephine::haptics::depth {

// If the next set of images is late, the previous one is extrapolated, then its force fades out.
inline constexpr double k_extrapolation_time = 0.05;  ///< s, from the end of the interval on
inline constexpr double k_fading = 0.05;              ///< s, after the extrapolation
/// Distance from the bounds of an object beyond which its images are not required, mm.
inline constexpr double k_bounds_margin = 2;

/// Request for images: a clip volume around a point, with pixels of one fixed lattice, so that two sets agree
/// where they overlap.
struct DepthView {
  glm::dvec3 middle{0.0};  ///< centre of the clip volume, mm, object's frame
  glm::dvec3 touch{0.0};   ///< point at which the motion must be accurate, mm, object's frame
  double edge = 20;        ///< mm, of the clip volume
  double pixel = 0.2;      ///< mm
  double time = 0;         ///< s since the operation began
  double interval = 0.01;  ///< s until the next set is due

  friend bool operator==(const DepthView&, const DepthView&) = default;
  /// Returns the lattice of the pixels. Error: invalid, or too large.
  Result<volume::Frame> lattice(glm::ivec3& size) const;
};

/// Extrapolation between two sets: the rigid motion that best fits the deformation around the touched point.
/// Computed with + - * / and roots only, for equal bits on any machine.
struct DepthMotion {
  glm::dvec3 pivot{0.0};   ///< mm, in the object's frame
  glm::dvec3 travel{0.0};  ///< mm per interval, of the pivot
  glm::dvec3 turn{0.0};    ///< per interval: the axis times the tangent of half the angle

  bool is_still() const noexcept { return travel == glm::dvec3(0) && turn == glm::dvec3(0); }
  /// Returns the displacement after `intervals`, which may be a fraction or negative.
  Placement after(double intervals) const noexcept;
};

/// A complete set of images. Immutable when made.
struct DepthSet {
  DepthView view;
  std::shared_ptr<const MeshTree> tree;  ///< surface within the clip volume, without its border
  glm::dvec3 low{0.0}, high{0.0};        ///< mm, box in which the surface is known
  DepthMotion motion;
  bool has_successor = false;   ///< the object changes later, and a new set is due
  Placement extrapolated = {};  ///< displacement that the previous set predicted for `view.time`
  double slack_before = 0;      ///< mm, `slack` of the previous set
  double slack = 0;             ///< mm, largest error of `motion` when the next set is due

  // Statistics.
  std::size_t pixels = 0;     ///< of all images of the set
  std::size_t crossings = 0;  ///< of rays with surfaces; in a picture: pixels with a measurement
  std::size_t open_rays = 0;  ///< rays with unknown sides: the object has a hole there
  std::uint64_t serial = 0;   ///< distinct for each set that a hand receives

  /// Returns the displacement since the set was drawn, at a time (s).
  Placement displacement_at(double time) const noexcept {
    return motion.is_still() ? Placement{} : motion.after((time - view.time) / view.interval);
  }
  /// Sets serial, prediction and previous slack from the previous set; null: this is the first set.
  void follow(const DepthSet* before) noexcept {
    serial = before ? before->serial + 1 : 1;
    extrapolated = before ? before->displacement_at(view.time) : Placement{};
    slack_before = before ? before->slack : 0;
  }
  /// Returns the hash of surface, motion and known box.
  std::uint64_t hash() const noexcept;
  /// Returns true if the surface within `reach` mm of p is known.
  bool is_known_around(const glm::dvec3& p, double reach) const noexcept;
};

/// Makes the same triangles of a net's surface as volume/surface/local_net.h, in spatial order, without the
/// part at the lattice's border. `codes`: output for MeshTree::of_ordered().
void triangles_of(const DepthNet& net, std::vector<glm::dvec3>& vertices,
                  std::vector<std::uint32_t>& triangles, std::vector<std::uint64_t>& codes);

/// A drawable object. Immutable; any thread.
class DepthSource {
 public:
  virtual ~DepthSource() = default;
  /// Draws a set; the same bits for any `threads`. Error: the object cannot be drawn.
  virtual Result<DepthSet> draw(const DepthView& view, int threads = 0) const = 0;
  /// Returns true if the object changes after a time (s).
  virtual bool is_moving(double time) const noexcept = 0;
  /// Returns the next time (s) at which the motion may change: until then all points move linearly. 1e300 if
  /// it never changes.
  virtual double next_motion_change(double /*time*/) const noexcept { return 1e300; }
  /// Returns true if the object cannot be drawn, since its pictures are submitted by the caller.
  virtual bool is_streamed() const noexcept { return false; }
  /// Returns the bounds over all time, mm, own frame; low > high if the object is empty.
  virtual void bounds(glm::dvec3& low, glm::dvec3& high) const noexcept = 0;
  /// Returns a hash of all its data.
  virtual std::uint64_t hash() const noexcept = 0;
  /// Returns the surface to display at a time (s), own frame; null: display the surface of the item.
  virtual std::shared_ptr<const MeshTree> surface_at(double /*time*/) const { return nullptr; }
};

/// Returns the set of an item by its index among the items touched by depth images; null: the set does not
/// exist yet.
inline const DepthSet* set_in(const TouchState& touch_state, int depth_index) noexcept {
  const auto d = static_cast<std::size_t>(depth_index);
  return d < touch_state.depths.size() ? touch_state.depths[d].get() : nullptr;
}

/// Makes a set from a net that was drawn for `view`.
DepthSet set_of(const DepthView& view, const DepthNet& net);

}  // namespace trephine::haptics::depth
