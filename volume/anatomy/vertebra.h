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
  double low = -18, high = 18;                           ///< extent of the vertebra along `up`

  glm::dvec3 world(const glm::dvec3& p) const noexcept { return middle + p.x * left + p.y * back + p.z * up; }
  glm::dvec3 local(const glm::dvec3& w) const noexcept;
};

/// Number of rays in a plane across the canal, counted from `back` toward `left`.
inline constexpr int k_canal_rays = 720;
/// Largest distance of the canal's wall from its centre, mm; bone farther away does not belong to the wall.
inline constexpr double k_canal_reach = 20;

/// Wall of the canal in the plane at `z` mm along `up`, before and after the operation.
struct CanalSection {
  double z = 0;
  std::vector<double> before, after;  ///< mm from the centre to the wall, per ray; negative: no wall
  std::vector<double> wall_end;       ///< mm to the far end of that bone, before the operation
  std::vector<char> is_own;           ///< the wall is of the labelled vertebra; without a label always true

  /// Returns true if a ray meets the wall; `is_after`: after the operation, else before. Ray numbers wrap
  /// around.
  bool is_closed(int ray, bool is_after) const noexcept;
  /// Returns true if the vertebra itself closes all rays within 35 degrees of straight back.
  bool has_roof(bool is_after) const noexcept;
  /// Returns the area within the wall, mm2. A straight line between the ends of the bone closes each opening;
  /// no ray is shorter than before the operation. Negative if less than half of the rays are closed.
  double area(bool is_after) const noexcept;
  /// Returns the distance between the ends of the bone at the widest opening in the roof, mm; 0: not open.
  double opening() const noexcept;
};
/// Returns the unit direction of a ray: x to the left, y to the back.
glm::dvec2 canal_ray_direction(int ray) noexcept;

/// Data from which the walls of a canal are found: bone, and the label of its vertebra, whose borders are
/// more exact than those of blurred bone; -1: no label.
struct CanalWalls {
  Field bone;
  int label = -1;
};
/// Returns the section at `z` mm along `up`. `after`: operated version; null: the untouched volume only.
CanalSection canal_section(const VertebraFrame& frame, double z, const CanalWalls& walls,
                           const Version* after);

/// Returns the distance from the centre of the canal to the wall in front of it (the back of the vertebra's
/// body), or behind it, mm, at mid-height; half of k_canal_reach without a wall.
double canal_front(const VertebraFrame& frame, const CanalWalls& walls);
double canal_back(const VertebraFrame& frame, const CanalWalls& walls);

/// Range of heights in which pedicles close the canal on both sides.
struct Pedicles {
  double low = 0, high = 0;  ///< mm along `up` of the frame
  double half_width = 0;     ///< mm, half of the canal's width between them
};
/// Finds the pedicles. `sections`: of the untouched vertebra, evenly spaced upward. Returns nullopt if no
/// section has pedicles on both sides.
std::optional<Pedicles> find_pedicles(const VertebraFrame& frame, const CanalWalls& walls,
                                      std::span<const CanalSection> sections);

/// Finds the labelled vertebra. Without a label, returns a frame in the canal around `canal_world` with the
/// patient's axes. `canal_world`: a position in the canal at the height of the lamina; null: searched for,
/// which requires a label.
Result<VertebraFrame, LocatedError> find_vertebra(const CanalWalls& walls, const glm::dvec3* canal_world);

}  // namespace trephine::volume
