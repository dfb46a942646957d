// Fit of a skull clamp: the job that puts the clamp onto three planned pins within its mechanical limits, and
// measures the result.
#pragma once

#include <string>
#include <vector>

#include "modules/skull_clamp/clamp_pose.h"
#include "sim/api/module.h"
#include "volume/base/located_error.h"

namespace trephine::skull_clamp {

/// Planned pins and posture. Settings of this module: undo does not change them.
struct ClampPlan {
  std::vector<glm::dvec3> pins;  ///< mm, world; at most three, the first is the single pin
  glm::dvec3 up{0, -1, 0};       ///< unit, away from the floor, in the frame of the head
  ClampModel model = ClampModel::standard;
  double turn = 0;  ///< degrees of the trunk about its long axis, to the left: 0 supine, 180 prone
  static const sim::Schema& schema();
};

/// Limits that a request sets instead of those of the chosen model. 0 (swing: below 0): those of the model.
struct RequestedLimits {
  double least_opening = 0, most_opening = 0, rocker_width = 0;  ///< mm
  double swing = -1;                                             ///< degrees
};

/// Job that fits the clamp onto the planned pins. It changes no anatomy.
struct FitClamp : RequestedLimits {
  std::string site;       ///< planned outline or trajectory of the approach; empty: the first of the plan
  std::int64_t item = 0;  ///< index of the bone's shape in the anatomy
  static const sim::Schema& schema();
  ClampLimits limits(const ClampPlan& plan) const noexcept;
};

/// A fitted clamp, the result of this module. Emitted at the middle between pin 1 and the rocker. Lists have
/// one entry per pin.
struct ClampFitted {
  bool is_fitted = false;
  std::vector<glm::dvec3> planned;                         ///< mm, world: positions that were requested
  std::vector<glm::dvec3> tips;                            ///< mm, world: on the outer table
  glm::dvec3 origin{0.0}, axis{1, 0, 0}, across{0, 1, 0};  ///< of the pose, see ClampPose
  double opening = 0;                                      ///< mm
  double swing = 0;                                        ///< degrees
  std::vector<double> residuals;    ///< mm from each planned position to the axis of its pin
  std::vector<double> gaps;         ///< mm along each pin from its position in the clamp to the outer table
  std::vector<double> thicknesses;  ///< mm of bone along each pin
  std::vector<double> scalps;       ///< mm of tissue over the bone, along each pin; empty without a skin
  double arm_depth = 0;             ///< mm, of the model, see ClampSize
  double touch_depth = 0;           ///< mm, greatest depth of arms or rocker in the head; 0: no contact
  double touch_length = 0;          ///< mm of arms and rocker in the head
  glm::dvec3 touch_at{0.0};         ///< mm, world: deepest point; valid if touch_depth > 0
  std::vector<double> angles;       ///< degrees between each pin and the outer table; 90: perpendicular
  bool has_band = false;            ///< the plan defines the sweatband
  glm::dvec3 band_normal{0, 0, 1};  ///< unit, upward; valid if has_band
  std::vector<double> heights;      ///< mm above the sweatband; empty without it
  glm::dvec3 centre{0.0};           ///< mm, world: of the skull, at the height of the sweatband
  double axis_miss = 0;             ///< mm from the centre to the axis of the clamp
  double pair_difference = 0;       ///< mm between the distances of pins 2 and 3 from the line through pin 1
                                    ///< and the centre
  std::string nearest;              ///< forbidden structure nearest to a tip; empty: none in reach
  double clearance = 0;             ///< mm from that tip to it; negative: inside
  std::string site;                 ///< name of the approach; empty: no approach is planned
  double access = 0;                ///< mm from the nearest pin to it
  double site_angle = 0;            ///< degrees between its normal and up
  double rotation = 0, flexion = 0, bend = 0;  ///< degrees of the neck: to the left, forward, to the left
  std::string trouble;                         ///< limit that kept the clamp off its pins; empty: no trouble
  static const sim::Schema& schema();
};

/// Arms or rocker of the fitted clamp pass through the head. Emitted with the fit, at the deepest point.
struct ClampTouchesHead {
  double depth = 0;   ///< mm
  double length = 0;  ///< mm of arms and rocker in the head
  static const sim::Schema& schema();
};

/// No clamp was fitted. Emitted at the pin that is the reason.
struct ClampFailed {
  std::string reason;
  static const sim::Schema& schema();
};

/// Angles of the neck of a patient who lies on a horizontal table, degrees.
struct NeckAngles {
  double rotation = 0, flexion = 0, bend = 0;
};
NeckAngles neck_angles(const glm::dvec3& up, double turn) noexcept;

/// Returns the pose of a fitted clamp.
ClampPose pose_of(const ClampFitted& fitted) noexcept;
/// Fits the clamp onto its three planned pins. Requires that check_fitting() accepts the request.
Result<ClampFitted, LocatedError> fit(const FitClamp& request, const sim::JobInput& input);
const sim::JobType& fit_job();
/// Returns an error unless three pins are planned, the limits are valid, and the approach exists.
Status check_fitting(const FitClamp& request, const sim::OperationState& operation);

}  // namespace trephine::skull_clamp
