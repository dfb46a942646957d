// VertebraFrame, CanalSection: location of a vertebra and its canal, found in the bone itself.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "volume/base/error.h"
#include "volume/base/located_error.h"
#include "volume/cuts/version.h"
#include "volume/scan/field.h"

namespace trephine::volume {

/// Axes of a vertebra, from the centre of its canal. World frame, mm.
struct VertebraFrame {
  glm::dvec3 middle{0.0};
  glm::dvec3 left{1, 0, 0}, back{0, 1, 0}, up{0, 0, 1};  ///< unit, orthogonal; up along its body
  double low = -18, high = 18;  ///< mm, extent of the vertebra along `up`; the defaults hold without a label

  glm::dvec3 world(const glm::dvec3& p) const noexcept { return middle + p.x * left + p.y * back + p.z * up; }
  glm::dvec3 local(const glm::dvec3& w) const noexcept;
};

/// Number of rays in a plane across the canal. Ray 0 points to `back`; numbers increase toward `left`.
inline constexpr int k_canal_rays = 720;
/// Largest distance of the canal's wall from its centre, mm; bone farther away does not belong to the wall.
inline constexpr double k_canal_reach = 20;

/// Wall of the canal in the plane at `z` mm along `up`, before and after the operation.
struct CanalSection {
  double z = 0;
  std::vector<double> before, after;  ///< mm from the centre to the wall, per ray; negative: no wall
  std::vector<double> wall_end;  ///< mm to the far side of the wall, before the operation; negative: no wall
  std::vector<char> is_own;      ///< the wall belongs to the labelled vertebra; always true without a label

  /// Returns true if a ray meets the wall, after the operation (`is_after`) or before it. Ray numbers wrap
  /// around.
  bool is_closed(int ray, bool is_after) const noexcept;
  /// Returns true if the vertebra itself closes all rays within 35 degrees of straight back.
  bool has_roof(bool is_after) const noexcept;
  /// Returns the area within the wall, mm2. A straight line between the ends of the bone closes each opening;
  /// no ray is shorter than before the operation. Negative if less than half of the rays are closed.
  double area(bool is_after) const noexcept;
  /// Returns the distance between the ends of the bone at the widest opening in the roof, mm. Counts only
  /// openings that were closed before the operation. 0 if there is no such opening.
  double opening() const noexcept;
};
/// Returns the unit direction of a ray: x to the left, y to the back.
glm::dvec2 canal_ray_direction(int ray) noexcept;

/// Data from which the walls of a canal are found: bone, and the label of the vertebra (-1: no label). The
/// borders of the label are more exact than those of blurred bone.
struct CanalWalls {
  Field bone;
  int label = -1;
};
/// Returns the section at `z` mm along `up`. `after`: operated version; null: not operated, so that
/// CanalSection::after equals CanalSection::before.
CanalSection canal_section(const VertebraFrame& frame, double z, const CanalWalls& walls,
                           const Version* after);

/// Return the median distance (mm) at mid-height from the centre of the canal to the wall in front of it,
/// which is the back of the vertebra's body, and to the wall behind it; half of k_canal_reach without a wall.
double canal_front(const VertebraFrame& frame, const CanalWalls& walls);
double canal_back(const VertebraFrame& frame, const CanalWalls& walls);

/// Range of heights in which pedicles close the canal on both sides.
struct Pedicles {
  double low = 0, high = 0;  ///< mm along `up` of the frame
  double half_width = 0;     ///< mm, half of the canal's width between them
};
/// Finds the pedicles. `sections`: of the uncut vertebra, evenly spaced upward. Returns nullopt if no
/// section has pedicles on both sides.
std::optional<Pedicles> find_pedicles(const VertebraFrame& frame, const CanalWalls& walls,
                                      std::span<const CanalSection> sections);

/// Finds the labelled vertebra. Without a label, returns a frame in the canal around `canal_world` with the
/// patient's axes. `canal_world`: a position in the canal at the height of the lamina; null: the function
/// finds such a position, which requires a label.
Result<VertebraFrame, LocatedError> find_vertebra(const CanalWalls& walls, const glm::dvec3* canal_world);

}  // namespace trephine::volume
