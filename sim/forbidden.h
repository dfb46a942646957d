// Forbidden structures: the distance of a tool's body at every tick, and the events of contact.
#pragma once

#include <algorithm>
#include <memory>
#include <string>

#include "haptics/mesh/mesh_tree.h"
#include "sim/value.h"
#include "volume/field.h"
#include "volume/occupancy.h"

namespace trephine::sim {

/// A tool's body: a ball, world frame.
struct ToolBall {
  glm::dvec3 centre{0.0};
  double radius = 0;      ///< mm
  bool is_blunt = false;  ///< while the tool works too: a foot that pushes a membrane off the bone
};

/// The position of a ball relative to a structure.
struct Nearness {
  double clearance = 0;  ///< mm to the surface; negative: so deep is the ball inside, at the nearest side
  bool is_centre_inside = false;  ///< of the structure
  bool has_surface = false;       ///< is any of the surface within reach?
  glm::dvec3 surface_world{0.0};  ///< then its point nearest to the centre
};

struct ForbiddenWatch;

/// A structure that must not be cut, as it was before anything was. Immutable. Distances to its surface as it
/// is drawn, which lies within half a voxel of where the structure ends; by what side of it a point is on,
/// its samples decide.
class Forbidden {
 public:
  /// `volume` is kept. Error when the structure is empty.
  static volume::Result<std::shared_ptr<const Forbidden>> build(std::shared_ptr<const volume::Volume> volume,
                                                                const volume::Shape& shape, int threads = 0);
  const std::string& name() const noexcept { return field_.shape().name; }
  const volume::Shape& shape() const noexcept { return field_.shape(); }
  /// mm, the longest side of its voxels.
  double voxel_mm() const noexcept {
    const glm::dvec3& spacing = volume_->frame.spacing();
    return std::max({spacing.x, spacing.y, spacing.z});
  }
  /// Largest distance that is measured, mm.
  static constexpr double k_reach = 20;
  /// mm from the ball to the structure, at most k_reach; negative: so deep is it inside. `expected`: about
  /// how much it will be; any guess gives the same answer, a good one sooner.
  double clearance(const ToolBall& ball, double expected = k_reach) const noexcept {
    return locate(ball, expected).clearance;
  }
  Nearness locate(const ToolBall& ball, double expected = k_reach) const noexcept;
  /// Returns the least clearance while the ball goes straight from `from` to its place, and `watch` follows
  /// its way in by the same places.
  double follow(const glm::dvec3& from, const ToolBall& ball, double expected,
                ForbiddenWatch& watch) const noexcept;
  /// The ball was set down at its place.
  double set_down(const ToolBall& ball, double expected, ForbiddenWatch& watch) const noexcept;
  /// The least while the ball goes straight from `from` to its place, by places half a voxel apart.
  double clearance(const glm::dvec3& from, const ToolBall& ball, double expected = k_reach) const noexcept;

 private:
  Forbidden(std::shared_ptr<const volume::Volume> volume, const volume::Shape& shape);
  double distance(const glm::dvec3& p, double reach, glm::dvec3& nearest_world) const noexcept;
  template <class Each>
  void for_places(const glm::dvec3& from, const glm::dvec3& to, const Each& each) const noexcept;

  std::shared_ptr<const volume::Volume> volume_;
  volume::Field field_;
  haptics::MeshTree surface_;  ///< world frame
  double step_mm_;
};

/// The tool's body came into a forbidden structure.
struct ForbiddenEntered {
  std::string structure;
  bool is_working = false;  ///< with its button down
  static const Schema& schema();
};
/// It left it again.
struct ForbiddenLeft {
  std::string structure;
  double deepest = 0;  ///< mm
  double seconds = 0;  ///< that it was inside
  static const Schema& schema();
};

/// Effect of a visit on a membrane, such as the dura. A tool that does not work pushes it off the bone ...
struct StructureStripped {
  std::string structure;
  double deepest = 0;  ///< mm
  static const Schema& schema();
};
/// ... one that works, with its button down, touches it ...
struct StructureTouched {
  std::string structure;
  double deepest = 0;
  static const Schema& schema();
};
/// ... and tears it where it goes deeper than k_tears, or not working deeper than k_bursts: emitted at once,
/// the others when it left.
struct StructureTorn {
  std::string structure;
  double deepest = 0;
  static const Schema& schema();
};
/// mm. Dura is about half a millimetre thick; how far it stretches before a blunt tool goes through is
/// assumed.
inline constexpr double k_tears = 0.5, k_bursts = 3;

/// Watch of one hand and one structure, since the start; undo does not change it.
struct ForbiddenWatch {
  bool is_inside = false;
  double clearance = Forbidden::k_reach;  ///< mm, in the newest tick
  double nearest = Forbidden::k_reach;    ///< mm, ever; negative: so deep along the way in
  // The way in of the visit that goes on. A tool that went through a brain to 2 mm before its far side is not
  // 2 mm deep: depth is measured to the side on which it entered.
  bool has_entry = false, is_beyond_middle = false;
  glm::dvec3 entry_world{0.0};               ///< the point of that side under which the tool is
  double depth = 0;                          ///< mm, now; 0 outside
  double deepest_now = 0;                    ///< mm, of the visit
  bool has_worked = false, is_torn = false;  ///< in it
  std::int64_t entries = 0, ticks_inside = 0, entered_tick = 0;
  /// Follows the way in: the ball went from `from_world` to its place, where `now` holds. `slack`: by how
  /// much the nearest point of a rough surface leaps, mm.
  void follow(const glm::dvec3& from_world, const ToolBall& ball, const Nearness& now, double slack) noexcept;
  static const Schema& schema();
};

}  // namespace trephine::sim
