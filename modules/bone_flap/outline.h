// Pyramid: from an apex within the head through the outline of a bone flap on the skull.
#pragma once

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <string>
#include <vector>

#include "volume/base/error.h"
#include "volume/base/located_error.h"
#include "volume/scan/solid_runs.h"

namespace trephine::bone_flap {

using volume::nearest_run, volume::Run, volume::runs_along;

/// Returns a rounded number as text: "12".
std::string rounded(double value);
/// Returns a number with one decimal as text: "1.4".
std::string tenths(double value);

/// Pyramid from an apex through a closed outline, mm. Bone inside it belongs to the flap.
struct Pyramid {
  std::vector<glm::dvec3> anchors_world;
  /// Centre and normal are means over the anchors, each weighted by half the length of its two segments.
  glm::dvec3 centre_world{0.0}, normal_world{0.0}, apex_world{0.0};
  glm::dvec3 right_world{0.0}, up_world{0.0};  ///< unit, orthogonal to the normal
  std::vector<glm::dvec2> plan;                ///< anchors, projected by project()

  std::size_t size() const noexcept { return anchors_world.size(); }
  const glm::dvec3& anchor(std::size_t i) const noexcept { return anchors_world[i % size()]; }
  /// Returns the projection from the apex onto the plane at distance 1, along `right_world` and `up_world`.
  /// Sets `is_ahead` to true if the point is on the outline's side of the apex.
  glm::dvec2 project(const glm::dvec3& p_world, bool& is_ahead) const noexcept;
  bool contains(const glm::dvec3& p_world) const noexcept;
};

/// Sets two unit vectors orthogonal to a unit normal, right-handed with it.
void set_orthogonal_axes(const glm::dvec3& normal, glm::dvec3& right, glm::dvec3& up) noexcept;
/// Returns true if a point is inside a closed polygon.
bool is_within(const std::vector<glm::dvec2>& loop, const glm::dvec2& p) noexcept;

/// Largest distance of an anchor from bone, mm.
inline constexpr double k_anchor_reach = 6;
/// Smallest distance between two successive anchors, mm.
inline constexpr double k_anchor_spacing = 1;

/// Returns the pyramid over an outline, or the reason why the outline is invalid. `distance`: mm from the
/// centre to the apex. Bone is where the field is not negative.
Result<Pyramid, LocatedError> make_pyramid(const std::vector<glm::dvec3>& anchors_world, double distance,
                                           const volume::Field& bone);

/// Sets the unit direction out of the head at a point on the skull: away from the centre of the bone around
/// it, and not toward the skull's other side. Returns false if there is no bone within
/// k_anchor_reach, or if bone surrounds the point evenly.
bool outward(const volume::Field& bone, const glm::dvec3& p_world, glm::dvec3& normal_world);

/// Returns `count` anchors in a ring on the skull, as an initial plan. The ring has the given diameter (mm),
/// and its centre is the bone nearest to `at_world`. Empty if no bone is within 30 mm. An anchor without bone
/// near it is set on a sphere of 75 mm radius.
std::vector<glm::dvec3> ring_of(const volume::Field& bone, const glm::dvec3& at_world, double diameter,
                                int count);

}  // namespace trephine::bone_flap
