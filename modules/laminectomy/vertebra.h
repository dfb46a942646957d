// Location of a vertebra and its canal, found in the bone itself.
#pragma once

#include <string>
#include <vector>

#include "volume/field.h"
#include "volume/version.h"

namespace trephine::laminectomy {

/// Directions of a vertebra, from the middle of its canal. World frame, mm.
struct VertebraFrame {
  glm::dvec3 middle{0.0};
  glm::dvec3 left{1, 0, 0}, back{0, 1, 0}, up{0, 0, 1};  ///< unit, at right angles; up as its body lies
  double low = -18, high = 18;                           ///< along `up`, between which the vertebra lies

  glm::dvec3 world(const glm::dvec3& p) const noexcept { return middle + p.x * left + p.y * back + p.z * up; }
  glm::dvec3 local(const glm::dvec3& w) const noexcept;
};

/// Reason and location of a failure.
struct Trouble {
  std::string why;
  glm::dvec3 at_world{0.0};
};

/// Rays of a plane across the canal, turned from `back` toward `left`.
inline constexpr int k_rays = 720;
/// Bone farther from the canal's middle does not belong to its wall, mm.
inline constexpr double k_reach = 20;

/// The canal's wall in the plane at `z` along `up`, as it was and as it is.
struct CanalSection {
  double z = 0;
  std::vector<double> before, after;  ///< mm, each ray to its wall; below 0: it meets none
  std::vector<double> wall_end;       ///< mm, where that bone ended before anything was cut
  std::vector<char> is_own;           ///< is that the labelled vertebra? Without a label all are

  /// Is the ray closed, before or after? Rays are counted around.
  bool is_closed(int ray, bool of_after) const noexcept;
  /// Has it a roof: are all rays within 35 degrees of straight back closed, by the vertebra itself?
  bool has_roof(bool of_after) const noexcept;
  /// mm2 within the wall; where it is open, within the straight line between the ends of the bone at the
  /// opening, and never less than before. Nothing (below 0) where less than half is closed.
  double area(bool of_after) const noexcept;
  /// mm, between the ends of the bone at the opening that was cut into the roof; 0: not open.
  double opening() const noexcept;
};
/// The direction of a ray, of unit length: x to the left, y to the back.
glm::dvec2 ray_direction(int ray) noexcept;

/// Walls of a canal: bone, and the label of its vertebra, which ends more exactly than blurred
/// walls do; -1: no label.
struct Walls {
  volume::Field bone;
  int label = -1;
};
/// `after`: null to look at the untouched volume alone.
CanalSection section_at(const VertebraFrame& frame, double z, const Walls& walls,
                        const volume::Version* after);

/// Finds the vertebra with that label; without one the bone around `canal_world`, patient upright.
/// `canal_world`: a place in its canal at the height of the lamina; null: it is found. False, and why, when
/// it is not found.
bool find_vertebra(const Walls& walls, const glm::dvec3* canal_world, VertebraFrame& frame, Trouble& trouble);

}  // namespace trephine::laminectomy
