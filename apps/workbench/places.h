// Places on the surface of what is touched: a script works there on whatever scan it is given.
#pragma once

#include "data-tools/script_file.h"
#include "haptics/device/pose_path.h"
#include "haptics/scene/touch_scene.h"
#include "volume/version.h"

namespace trephine::workbench {

/// A point of the surface with its frame, and how thick the solid is below it; world, mm. Seen from outside
/// `along` points to the right and `across` upward.
struct Place {
  std::string name;
  glm::dvec3 point{0.0}, along{1, 0, 0}, across{0, 1, 0}, outward{0, 0, 1};
  double thickness = 0;  ///< along the normal; 0: nothing ends within 20 mm

  glm::dvec3 direction(const glm::dvec3& seen) const noexcept {
    return seen.x * along + seen.y * across + seen.z * outward;
  }
  glm::dvec3 at(const glm::dvec3& seen) const noexcept { return point + direction(seen); }
};

/// First crossing of a ray from outside toward the middle of the scan with the first shape. Error
/// when none does.
volume::Result<Place> find_place(const data_tools::ScriptPlace& request, const haptics::TouchScene& scene,
                                 const volume::Version& untouched);
/// The hand's points, seen from the place: along, across, height over the surface there.
std::vector<haptics::PosePath::Sample> samples_at(const Place& place, const data_tools::ScriptHand& hand,
                                                  const haptics::TouchScene& scene,
                                                  const volume::Version& untouched);
/// Rotation of a tool whose shaft points that way: the shortest way from upright.
glm::dquat turn_of_shaft(const glm::dvec3& shaft) noexcept;
/// Can one look through the solid there, along the normal?
bool is_open(const Place& place, const haptics::TouchScene& scene, const volume::Version& version);

}  // namespace trephine::workbench
