// Place: a point of the surface, found on any scan, at which a script works.
#pragma once

#include "data-tools/cases/script_file.h"
#include "haptics/device/pose_path.h"
#include "haptics/scene/touch_scene.h"
#include "sim/engine/engine.h"
#include "volume/cuts/version.h"
#include "volume/scan/surgical_plan.h"

namespace trephine::workbench {

/// A point of the surface with its frame, and the thickness of the solid below it; world, mm. As viewed from
/// outside, `along` points to the right and `across` upward.
struct Place {
  std::string name;
  glm::dvec3 point{0.0}, along{1, 0, 0}, across{0, 1, 0}, outward{0, 0, 1};
  double thickness = 0;  ///< mm, of the solid along the normal; 0: no end within 20 mm, or no solid
  /// Length of the trajectory, from whose entry heights are measured, mm; 0: a point of the surface.
  double trajectory_length = 0;
  std::int64_t body = 0;  ///< number of the body that the place follows; 0: a fixed place

  /// World direction of local coordinates (along, across, outward).
  glm::dvec3 direction(const glm::dvec3& local) const noexcept {
    return local.x * along + local.y * across + local.z * outward;
  }
  /// World position of local coordinates, mm.
  glm::dvec3 at(const glm::dvec3& local) const noexcept { return point + direction(local); }
};

/// Finds the first suitable crossing of a ray, from outside to the middle of the scan, with the first shape.
/// Error if there is no such crossing.
Result<Place> find_place(const data_tools::ScriptPlace& request, const haptics::TouchScene& scene,
                         const volume::Version& untouched);
/// Returns the entry of a trajectory as a place: outward along it. Its thickness is that of the first solid
/// that the trajectory meets, from 5 mm outside its entry to its target.
Place place_of(const volume::PlannedTrajectory& trajectory, const data_tools::ScriptPlace& request,
               const haptics::TouchScene& scene, const volume::Version& untouched);
/// Returns a place at this moment: a place on a body is in the middle of the body at its current pose, with
/// the axes of its frame. Error if the body does not exist.
Result<Place> current_place(const Place& place, const sim::Engine& engine);
/// Returns the places, with current positions for those on bodies that `words` names. Error if such a body
/// does not exist, is held, or moves.
Result<std::vector<Place>> places_in(const sim::OperationState& operation, const std::vector<Place>& places,
                                     const std::string& words);
/// Converts a hand's points, relative to a place (along, across, height over the surface), to poses.
std::vector<haptics::PosePath::Sample> samples_at(const Place& place, const data_tools::ScriptHand& hand,
                                                  const haptics::TouchScene& scene,
                                                  const volume::Version& untouched);
/// Returns the rotation of a tool with this direction of its shaft: the shortest one from upright.
glm::dquat turn_of_shaft(const glm::dvec3& shaft) noexcept;
/// True if the solid is open at a place along the normal, from outside to its other side.
bool is_open(const Place& place, const haptics::TouchScene& scene, const volume::Version& version);

}  // namespace trephine::workbench
