// The outline of a bone flap on the skull, and the pyramid that it makes with an apex within the head.
#pragma once

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <string>
#include <vector>

#include "volume/bone_labels.h"
#include "volume/field.h"

namespace trephine::bone_flap {

/// Why there is no flap, and where.
struct Trouble {
  std::string why;
  glm::dvec3 at_world{0.0};
};

/// "12", for words.
std::string whole(double value);
/// "1.4"
std::string tenths(double value);

/// From an apex through a closed outline. What lies within is the flap's.
struct Pyramid {
  std::vector<glm::dvec3> anchors_world;
  /// Each anchor weighs half of the two segments that meet in it.
  glm::dvec3 centre_world{0.0}, normal_world{0.0}, apex_world{0.0};
  glm::dvec3 right_world{0.0}, up_world{0.0};  ///< at right angles to the normal
  std::vector<glm::dvec2> plan;                ///< the anchors as the apex sees them, at a distance of 1

  std::size_t size() const noexcept { return anchors_world.size(); }
  const glm::dvec3& anchor(std::size_t i) const noexcept { return anchors_world[i % size()]; }
  /// As the apex sees it; `is_ahead`: it lies on the outline's side of the apex.
  glm::dvec2 seen(const glm::dvec3& p_world, bool& is_ahead) const noexcept;
  bool contains(const glm::dvec3& p_world) const noexcept;
};

/// Returns two directions at right angles to a normal, right-handed with it.
void beside(const glm::dvec3& normal, glm::dvec3& right, glm::dvec3& up) noexcept;
/// Does a point lie within a closed line?
bool is_within(const std::vector<glm::dvec2>& loop, const glm::dvec2& p) noexcept;

/// mm: as far an anchor may lie from bone.
inline constexpr double k_anchor_reach = 6;

/// `distance`: mm from the centre to the apex. Bone is where the field is not negative. False: the anchors
/// make none.
bool make_pyramid(const std::vector<glm::dvec3>& anchors_world, double distance, const volume::Field& bone,
                  Pyramid& made, Trouble& trouble);

/// The way out of the head from a point on the skull, unit: away from the middle of the bone around it, and
/// not to the skull's other side. False: there is no bone around it.
bool outward(const volume::Field& bone, const glm::dvec3& p_world, glm::dvec3& normal_world);

/// Anchors in a ring on the skull, as a plan to begin with: of such a diameter (mm) around the bone that is
/// nearest to a place, empty without bone within 30 mm. Where no bone is found an anchor lies off the bone.
std::vector<glm::dvec3> ring_of(const volume::Field& bone, const glm::dvec3& at_world, double diameter,
                                int count);

/// Bone along a line, mm from its start.
struct Run {
  double low, high;
};
/// Runs of bone between t0 and t1. Runs are joined across gaps of at most `space` mm, and, where `labels` is
/// given, across gaps that lie in a labelled bone, however wide.
std::vector<Run> runs_along(const volume::Field& bone, const glm::dvec3& start_world, const glm::dvec3& along,
                            double t0, double t1, double space, const volume::BoneLabels* labels = nullptr);
/// The one whose outer end is nearest to t; null: none is within reach.
const Run* nearest(const std::vector<Run>& runs, double t, double reach);

}  // namespace trephine::bone_flap
