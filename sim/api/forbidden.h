// Forbidden: a structure that a tool must not enter, with the tool's distance at every tick and events of
// contact.
#pragma once

#include <algorithm>
#include <memory>
#include <string>

#include "haptics/mesh/mesh_tree.h"
#include "sim/api/value.h"
#include "volume/scan/field.h"
#include "volume/scan/occupancy.h"

namespace trephine::sim {

/// A tool's body: a ball in the world frame.
struct ToolBall {
  glm::dvec3 centre{0.0};  ///< mm
  double radius = 0;       ///< mm
  bool is_blunt = false;   ///< does not cut even while the tool works, such as a foot that pushes a membrane
};

/// Position of a ball relative to a structure.
struct Nearness {
  double clearance = 0;  ///< mm from the ball to the surface; negative: depth below the nearest side
  bool is_centre_inside = false;
  bool has_surface = false;       ///< some of the surface is within reach
  glm::dvec3 surface_world{0.0};  ///< mm; if has_surface: the surface point nearest to the ball's centre
};

struct ForbiddenWatch;

/// A structure that a tool must not enter, in its state before any cut. Immutable. Distances are to its
/// displayed surface. For a shape of a volume, this surface is at most half a voxel from the structure's
/// boundary; the samples decide on which side a point is.
class Forbidden {
 public:
  /// Builds the structure of a shape of `volume`, which it keeps. Error if the structure is empty, or if the
  /// shape is a label and the volume has no labels.
  static Result<std::shared_ptr<const Forbidden>> build(std::shared_ptr<const volume::Volume> volume,
                                                        const volume::Shape& shape, int threads = 0);
  /// Builds the solid inside a model at rest. Error if the surface is not closed, or faces inward.
  static Result<std::shared_ptr<const Forbidden>> build(const std::string& name,
                                                        const haptics::MeshTree& model,
                                                        const haptics::Placement& placement);
  const std::string& name() const noexcept { return name_; }
  /// Returns true for the dura of a head, which carries the structures behind it while a blunt tool pushes
  /// it.
  bool is_membrane() const noexcept { return is_membrane_; }
  /// Shape of the anatomy; null for a model.
  const volume::Shape* shape() const noexcept { return volume_ ? &field_.shape() : nullptr; }
  /// Returns the longest side of its voxels, mm; for a model twice the spacing of positions along a path.
  double voxel_mm() const noexcept {
    if (!volume_) return 2 * step_mm_;
    const glm::dvec3& spacing = volume_->frame.spacing();
    return std::max({spacing.x, spacing.y, spacing.z});
  }
  /// True if a point (world, mm) is inside.
  bool contains(const glm::dvec3& p) const noexcept;
  /// Largest measured distance, mm.
  static constexpr double k_reach = 20;
  /// Distance up to which a watch measures in every tick, mm.
  static constexpr double k_always_measured = 3;
  /// Returns the distance from the ball to the structure, mm, at most k_reach; negative: depth inside.
  /// `expected`: an estimate of it, which changes the cost but not the result.
  double clearance(const ToolBall& ball, double expected = k_reach) const noexcept {
    return locate(ball, expected).clearance;
  }
  Nearness locate(const ToolBall& ball, double expected = k_reach) const noexcept;
  /// Returns the least clearance, mm, while the ball moves straight from `from` to its centre, as
  /// clearance(from, ...) does, and records the ball's path of entry in `watch`.
  double follow(const glm::dvec3& from, const ToolBall& ball, double expected,
                ForbiddenWatch& watch) const noexcept;
  /// Starts a path at the ball's position. Returns the clearance, mm.
  double begin_path(const ToolBall& ball, double expected, ForbiddenWatch& watch) const noexcept;
  /// Returns the least clearance, mm, while the ball moves straight from `from` to its centre, at positions
  /// half of a voxel's shortest side apart; 0.25 mm for a model.
  double clearance(const glm::dvec3& from, const ToolBall& ball, double expected = k_reach) const noexcept;

 private:
  Forbidden(std::shared_ptr<const volume::Volume> volume, const volume::Shape& shape);
  Forbidden(std::string name, haptics::MeshTree surface);
  bool is_inside(const glm::dvec3& p, double reach) const noexcept;
  double distance(const glm::dvec3& p, double reach, glm::dvec3& nearest_world) const noexcept;
  template <class Each>
  void for_positions(const glm::dvec3& from, const glm::dvec3& to, const Each& each) const noexcept;

  std::string name_;
  bool is_membrane_;
  std::shared_ptr<const volume::Volume> volume_;  ///< null for a model
  volume::Field field_;
  haptics::MeshTree surface_;  ///< world frame
  double step_mm_;
};

/// The tool's body entered a forbidden structure.
struct ForbiddenEntered {
  std::string structure;
  bool is_working = false;  ///< its button is pressed, and its body is not blunt
  static const Schema& schema();
};
/// The tool's body left the structure.
struct ForbiddenLeft {
  std::string structure;
  double deepest = 0;  ///< mm
  double seconds = 0;  ///< duration of the visit
  static const Schema& schema();
};

/// A tool that did not work, or a blunt part of a tool, pushed a membrane, such as the dura, off the bone.
/// Emitted with the tool's greatest depth when the tool leaves the membrane, or when a flap is cut.
struct StructureStripped {
  std::string structure;
  double deepest = 0;  ///< mm
  static const Schema& schema();
};
/// A tool that worked, that is, with its button pressed, touched the membrane and did not tear it. Emitted
/// with the tool's greatest depth when the tool leaves the membrane.
struct StructureTouched {
  std::string structure;
  double deepest = 0;  ///< mm
  static const Schema& schema();
};
/// The tool tore the membrane: it was deeper than k_tear_depth while it worked, or deeper than
/// k_blunt_tear_depth while it did not work or its body was blunt. Emitted at once.
struct StructureTorn {
  std::string structure;
  double deepest = 0;  ///< mm
  static const Schema& schema();
};
/// Depths at which a membrane tears, mm. Dura is about half a millimetre thick; its stretch before a blunt
/// tool goes through it is an assumption.
inline constexpr double k_tear_depth = 0.5, k_blunt_tear_depth = 3;

/// Watch of one hand and one structure since the start; undo does not change it.
struct ForbiddenWatch {
  /// A visit begins at a clearance below 0 and ends at a clearance of k_leaving_clearance. A tool that
  /// trembles at a surface therefore makes only one visit.
  static constexpr double k_leaving_clearance = 0.2;  ///< mm
  bool is_inside = false;                             ///< during a visit
  /// Clearance in the newest tick, mm. A value that exceeds both `nearest` and k_always_measured may be only
  /// a lower bound; Engine::clearance() measures the clearance itself.
  double clearance = Forbidden::k_reach;
  double nearest = Forbidden::k_reach;  ///< mm, least so far; negative: depth along the path of entry
  double measured = 0;                  ///< mm, last measured clearance
  glm::dvec3 measured_at{0.0};          ///< mm, centre of the ball at that measurement
  // Path of entry of the current visit. Depth is measured to the side of entry: a tool that passed through a
  // brain to 2 mm before its far side is not 2 mm deep.
  bool has_entry = false, is_beyond_middle = false;
  glm::dvec3 entry_world{0.0};    ///< mm, surface point through which the ball entered
  glm::dvec3 entry_outward{0.0};  ///< unit vector from there to the ball's centre before it entered
  double depth = 0;               ///< mm, current; 0 outside
  double deepest_now = 0;         ///< mm, greatest depth in the current visit
  glm::dvec3 deepest_world{0.0};  ///< mm, centre of the ball at that depth
  bool has_worked = false, is_torn = false;  ///< during the visit
  bool is_working = false;                   ///< the body cuts in the newest tick
  double deepest_working = 0;                ///< mm, greatest depth in the current visit while it worked
  std::int64_t entries = 0, ticks_inside = 0, entered_tick = 0;
  /// Computes a lower bound of the clearance from the last measurement. If the bound exceeds both `nearest`
  /// and k_always_measured, sets `clearance` to it and returns true. Otherwise the clearance must be
  /// measured.
  bool is_far(const ToolBall& ball) noexcept;
  /// Follows the path of entry while the ball moves from `from_world` to its centre. `nearness`: at the
  /// centre. `slack`: jumps of the nearest point of a rough surface, mm. `is_membrane`: as
  /// Forbidden::is_membrane(). A ball behind an intact membrane, which it pushes, keeps its entry.
  void follow(const glm::dvec3& from_world, const ToolBall& ball, const Nearness& nearness, double slack,
              bool is_membrane) noexcept;
  static const Schema& schema();
};

}  // namespace trephine::sim
