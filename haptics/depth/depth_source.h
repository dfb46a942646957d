// Touch of anything that can be drawn: its surface around a hand, from depth images made again whenever it
// changes.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <memory>

#include "haptics/depth/depth_net.h"
#include "haptics/mesh/mesh_tree.h"
#include "haptics/scene/touch_state.h"

namespace trephine::haptics::depth {

// A set that is late.
inline constexpr double k_foretold = 0.05;  ///< s beyond its interval that it goes on as it went
inline constexpr double k_fading = 0.05;    ///< s after those in which it lets go
inline constexpr double k_beside = 2;  ///< mm outside the reach of an object: no images are awaited there

/// Request for images: a clip volume around a place, pixels of one fixed lattice, so that two sets agree
/// where both look.
struct DepthView {
  glm::dvec3 middle{0.0};  ///< mm, of the thing's own frame
  glm::dvec3 touch{0.0};   ///< mm: where the motion has to be right
  double edge = 20;        ///< mm, of the clip volume
  double pixel = 0.2;      ///< mm
  double time = 0;         ///< s since the operation began
  double interval = 0.01;  ///< s until the next set is due

  friend bool operator==(const DepthView&, const DepthView&) = default;
  /// The lattice of those pixels. Error: invalid, or too large.
  volume::Result<volume::Frame> lattice(glm::ivec3& size) const;
};

/// Extrapolation between two sets: a rigid motion, as near as one comes to the deformation around
/// the middle. Of the same bits on any machine: only + - * / and roots.
struct DepthMotion {
  glm::dvec3 pivot{0.0};   ///< mm, of the thing's frame
  glm::dvec3 travel{0.0};  ///< mm in one interval, of the pivot
  glm::dvec3 turn{0.0};    ///< in one interval: its axis, as long as the tangent of half its angle

  bool is_still() const noexcept { return travel == glm::dvec3(0) && turn == glm::dvec3(0); }
  /// Displacement after so many intervals; before the first they are negative.
  Placement after(double intervals) const noexcept;
};

/// A complete set. Immutable when made.
struct DepthSet {
  DepthView view;
  std::shared_ptr<const MeshTree> tree;  ///< of the surface within the clip volume, without its border
  glm::dvec3 low{0.0}, high{0.0};        ///< mm: within it all is known
  DepthMotion motion;
  bool goes_on = false;     ///< it looks otherwise later, and a new set is due
  Placement foretold = {};  ///< where the set before put it at `view.time`
  double slack_before = 0;  ///< mm, that set's
  double slack = 0;  ///< mm that the surface may be off where the motion puts it when the next set is due

  // Cost.
  std::size_t pixels = 0;     ///< of three images
  std::size_t crossings = 0;  ///< layers that they met
  std::size_t open_rays = 0;  ///< rays with unknown sides: the object has a hole there
  std::uint64_t serial = 0;   ///< another for each that a hand is given

  /// Displacement at a time (s) since it was drawn.
  Placement place_at(double time) const noexcept {
    return motion.is_still() ? Placement{} : motion.after((time - view.time) / view.interval);
  }
  /// It comes after another one, or is the first (null).
  void follow(const DepthSet* before) noexcept {
    serial = before ? before->serial + 1 : 1;
    foretold = before ? before->place_at(view.time) : Placement{};
    slack_before = before ? before->slack : 0;
  }
  /// Box of the touched object.
  std::uint64_t hash() const noexcept;
  /// Does all within `reach` mm of p lie where it looked?
  bool knows(const glm::dvec3& p, double reach) const noexcept;
};

/// The surface of a net as triangles: those of volume/local_net.h, without what lies at the lattice's border.
/// In the order of where they are: `codes` for MeshTree::of_ordered().
void triangles_of(const DepthNet& net, std::vector<glm::dvec3>& vertices,
                  std::vector<std::uint32_t>& triangles, std::vector<std::uint64_t>& codes);

/// Something that can be drawn. Immutable; any thread.
class DepthSource {
 public:
  virtual ~DepthSource() = default;
  /// Returns the same bits for any `threads`. Error: nothing of it is visible.
  virtual volume::Result<DepthSet> draw(const DepthView& view, int threads = 0) const = 0;
  /// Does it look otherwise at another time?
  virtual bool is_moving(double time) const noexcept = 0;
  /// The next time at which it may turn: from here until then everything of it goes straight. Beyond all
  /// numbers where it never does.
  virtual double turns_at(double /*time*/) const noexcept { return 1e300; }
  /// It is not drawn: its pictures are submitted by sim::AdoptPicture.
  virtual bool comes_in() const noexcept { return false; }
  /// mm, its own frame: all places where it ever is; low > high where there is nothing.
  virtual void bounds(glm::dvec3& low, glm::dvec3& high) const noexcept = 0;
  /// Hash of all its data.
  virtual std::uint64_t hash() const noexcept = 0;
  /// Contents of its picture at a time, own frame; null: the item's own.
  virtual std::shared_ptr<const MeshTree> look(double /*time*/) const { return nullptr; }
};

/// The set of an item by its place among those touched by depth images; null: not made yet.
inline const DepthSet* set_in(const TouchState& seen, int depth) noexcept {
  const auto d = static_cast<std::size_t>(depth);
  return d < seen.depths.size() ? seen.depths[d].get() : nullptr;
}

/// A set of a net that was drawn so.
DepthSet set_of(const DepthView& view, const DepthNet& net);

}  // namespace trephine::haptics::depth
