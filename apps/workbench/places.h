// Place: a named position at which a script works: a point of the surface that is found on any scan, the
// entry of a trajectory, or the middle of a body.
#pragma once

#include "data-tools/cases/script_file.h"
#include "haptics/device/pose_path.h"
#include "haptics/scene/touch_scene.h"
#include "sim/engine/engine.h"
#include "volume/cuts/version.h"
#include "volume/scan/surgical_plan.h"

namespace trephine::workbench {

/// A point with its frame, and the thickness of the solid below it; world, mm. As viewed from outside,
/// `along` points to the right and `across` upward.
struct Place {
  std::string name;
  glm::dvec3 point{0.0}, along{1, 0, 0}, across{0, 1, 0}, outward{0, 0, 1};
  double thickness = 0;  ///< mm, of the solid along the normal; 0: no end found within 20 mm, or no solid
  /// Length of the trajectory, mm, if the place is its entry: heights are then measured from the entry. 0:
  /// the place is no trajectory.
  double trajectory_length = 0;
  std::int64_t body = 0;  ///< number of the body that the place follows; 0: a fixed place

  /// World direction of local coordinates (along, across, outward).
  glm::dvec3 direction(const glm::dvec3& local) const noexcept {
    return local.x * along + local.y * across + local.z * outward;
  }
  /// World position of local coordinates, mm.
  glm::dvec3 at(const glm::dvec3& local) const noexcept { return point + direction(local); }
};

/// Finds a place on the surface of the first item of the scene. Tries the requested rays in order, each from
/// outside to the middle of the scan. The place is the first crossing whose surface faces outside and whose
/// solid has the requested thickness. Error if no ray has such a crossing.
Result<Place> find_place(const data_tools::ScriptPlace& request, const haptics::TouchScene& scene,
                         const volume::Version& uncut);
/// Returns the entry of a trajectory as a place; `outward` is the direction from the target to the entry. The
/// thickness is that of the first solid that the line from 5 mm outside the entry to the target meets.
Place place_of(const volume::PlannedTrajectory& trajectory, const data_tools::ScriptPlace& request,
               const haptics::TouchScene& scene, const volume::Version& uncut);
/// Returns the current position of a place. A place on a body is at the middle of the body at its current
/// pose, with the axes of the body's frame. Error if the body does not exist.
Result<Place> current_place(const Place& place, const sim::Engine& engine);
/// Returns all places. Those on bodies that `words` (of a command) names in braces get their current
/// positions. Error if such a body does not exist, is held, or moves.
Result<std::vector<Place>> places_in(const sim::OperationState& operation, const std::vector<Place>& places,
                                     const std::string& words);
/// Converts a hand's points, relative to a place (along, across, height over the surface or along the
/// trajectory), to poses. `uncut`: the anatomy before any cut.
std::vector<haptics::PosePath::Sample> samples_at(const Place& place, const data_tools::ScriptHand& hand,
                                                  const haptics::TouchScene& scene,
                                                  const volume::Version& uncut);
/// Returns the shortest rotation that turns a tool from upright (shaft along z) to this direction of its
/// shaft.
glm::dquat turn_of_shaft(const glm::dvec3& shaft) noexcept;
/// True if the line through a place along its normal is free of solid, from 5 mm outside to 2.5 mm past the
/// far side of the solid or past the target of the trajectory.
bool is_open(const Place& place, const haptics::TouchScene& scene, const volume::Version& version);

}  // namespace trephine::workbench
