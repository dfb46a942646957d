// FallThroughJudge: judges servo steps for fall-through. A fall-through is a path from the old to the new
// proxy that meets the solid, or a loss of contact without a free path from the proxy to the HIP. Uses
// voxels, distances and exact traversal alone; shares no code with haptics.
#pragma once

#include <functional>
#include <glm/vec3.hpp>
#include <span>

namespace trephine::verify {

/// Returns true if a voxel's centre is solid. Called inside the grid only; voxels outside are air.
using SolidVoxels = std::function<bool(int, int, int)>;

struct StepUnderJudgement {
  std::span<const glm::dvec3> path_volume;  ///< waypoints from the old proxy to the new one, volume frame
  glm::dvec3 hip_volume;
  bool has_contact;
  bool is_buried;  ///< the step reported that matter grew over its proxy
};

class FallThroughJudge {
 public:
  /// The solid is the union of the cubes of solid voxels.
  FallThroughJudge(const glm::ivec3& size, SolidVoxels solid);
  /// Returns true if a segment (or a point, passed twice) meets the solid; volume frame.
  using MeetsSolid = std::function<bool(const glm::dvec3&, const glm::dvec3&)>;
  explicit FallThroughJudge(MeetsSolid meets_solid) : meets_solid_(std::move(meets_solid)) {}

  /// Judges one step. Call once per step, in order. Only steps whose last proxy was in free space are judged.
  void judge_step(const StepUnderJudgement& step);
  bool meets_solid(const glm::dvec3& a, const glm::dvec3& b) const { return meets_solid_(a, b); }
  /// Returns the last proxy; null if it is unknown or was inside the solid.
  const glm::dvec3* free_proxy() const { return has_last_ && !is_inside_ ? &last_ : nullptr; }
  /// Sets the last proxy, which a moving object carried to the start of the next path. `is_fall`: the carried
  /// proxy passed through another object, which counts as a fall-through.
  void set_carried_proxy(const glm::dvec3& position, bool is_fall) {
    last_ = position;
    fall_throughs_ += is_fall;
  }
  /// Forgets the last proxy. Call after the tool was set to another position without a motion.
  void restart() { has_last_ = false; }
  /// Announces that `meets_solid` describes another solid from the next step on. Only that step may report
  /// that matter grew over its proxy, and only if the new solid contains the last proxy; any other such
  /// report counts as a fall-through.
  void solid_changed() { has_changed_ = true; }

  long steps() const { return steps_; }
  /// Returns the number of steps that could be judged: the previous proxy was known and free.
  long judged() const { return judged_; }
  long fall_throughs() const { return fall_throughs_; }
  /// Returns the number of steps that reported restored matter over their proxy, justified or not.
  long buried_starts() const { return buried_starts_; }

 private:
  MeetsSolid meets_solid_;
  glm::dvec3 last_{0.0};
  bool has_last_ = false, is_inside_ = false, has_changed_ = false;
  long steps_ = 0, judged_ = 0, fall_throughs_ = 0, buried_starts_ = 0;
};

/// Returns the resting point of a frictionless proxy on voxel cubes. The proxy starts at `proxy` and
/// decreases its distance from the HIP (mm). In each free cube it moves to the point nearest to the HIP, and
/// then into a free cube behind a face that contains this point, if that brings it nearer. `axes_mm`: columns
/// of the volume's frame.
glm::dvec3 resting_point_on_cubes(const glm::ivec3& size, const SolidVoxels& solid,
                                  const glm::dvec3 axes_mm[3], const glm::dvec3& proxy_volume,
                                  const glm::dvec3& hip_volume);

}  // namespace trephine::verify
