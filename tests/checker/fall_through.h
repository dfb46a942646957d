// Judges every servo step for fall-through: the path from the old to the new proxy meets the method's solid,
// or contact is lost without a free path from proxy to HIP. Works from voxels, distances and exact traversal
// alone; shares no code with haptics.
#pragma once

#include <functional>
#include <glm/vec3.hpp>
#include <span>

namespace trephine::checker {

/// Is a voxel's centre solid? Voxels outside the grid are air; the judge asks only inside.
using SolidVoxels = std::function<bool(int, int, int)>;

struct StepUnderJudgement {
  std::span<const glm::dvec3> path_volume;  ///< waypoints from the old proxy to the new one, volume frame
  glm::dvec3 hip_volume;
  bool has_contact;
  bool is_buried;  ///< the step said that matter grew over its proxy
};

class FallThroughJudge {
 public:
  /// The solid is the union of the cubes of solid voxels.
  FallThroughJudge(const glm::ivec3& size, SolidVoxels solid);
  /// The solid is whatever this says a segment (or a point, twice) meets; volume frame.
  using MeetsSolid = std::function<bool(const glm::dvec3&, const glm::dvec3&)>;
  explicit FallThroughJudge(MeetsSolid meets_solid) : meets_solid_(std::move(meets_solid)) {}

  /// Looks at one step; steps come in order. Only proxies in free space (touching from the front) are judged.
  void judge_step(const StepUnderJudgement& step);
  bool meets_solid(const glm::dvec3& a, const glm::dvec3& b) const { return meets_solid_(a, b); }
  /// Where the proxy was; null when it is not known, or was inside.
  const glm::dvec3* free_proxy() const { return has_last_ && !is_inside_ ? &last_ : nullptr; }
  /// What moves took the proxy along, to where the next path begins; `is_fall`: through something else.
  void carried_to(const glm::dvec3& place, bool is_fall) {
    last_ = place;
    fall_throughs_ += is_fall;
  }
  /// Forget the last proxy: the tool was set elsewhere.
  void restart() { has_last_ = false; }
  /// From the next step on the solid is another: `meets_solid` answers for it. Only such a step may say that
  /// matter grew over its proxy, and only where the new solid holds the last proxy; any other that says so
  /// counts as a fall-through.
  void solid_changed() { has_changed_ = true; }

  long steps() const { return steps_; }
  /// Of these, those that could have been found to fall: the proxy before was known, and free.
  long judged() const { return judged_; }
  long fall_throughs() const { return fall_throughs_; }
  long buried_starts() const { return buried_starts_; }  ///< steps that said so, rightly or not

 private:
  MeetsSolid meets_solid_;
  glm::dvec3 last_{0.0};
  bool has_last_ = false, is_inside_ = false, has_changed_ = false;
  long steps_ = 0, judged_ = 0, fall_throughs_ = 0, buried_starts_ = 0;
};

/// Where a frictionless proxy on the same voxel cubes would rest: from `proxy` downhill in |p - HIP| (mm)
/// through face-connected free cubes, each left at its point nearest to the HIP. `axes_mm`: columns of the
/// volume's frame.
glm::dvec3 resting_point_on_cubes(const glm::ivec3& size, const SolidVoxels& solid,
                                  const glm::dvec3 axes_mm[3], const glm::dvec3& proxy_volume,
                                  const glm::dvec3& hip_volume);

}  // namespace trephine::checker
