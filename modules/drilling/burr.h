// Burr: removes the bone that a rotating burr sweeps, at a rate set by contact force, speed and bone.
#pragma once

#include "modules/drilling/cutting.h"
#include "sim/api/module.h"

namespace trephine::drilling {

enum class Shape : std::uint8_t { sphere, cylinder, barrel, match_head };

/// Parameters of a burr.
struct Burr {
  double diameter = 4;        ///< mm, at the widest point
  double removal_rate = 0;    ///< mm^3/s in contact; 0: by contact force, speed and bone (removal_rate())
  double feed_limit = 40;     ///< mm/s, fastest motion through matter
  bool is_kinematic = false;  ///< the burr follows the hand and removes all that it sweeps, without contact
  bool is_round =
      false;  ///< all of the burr touches; its centre is at the position of the hand; false: a point touches
  Shape shape = Shape::sphere;
  Grade grade = Grade::cutting;
  double rpm = 60000;   ///< 1/min, of the spindle
  double length = 0;    ///< mm; not used for a ball; 0: the usual length of the shape
  double shaft = 0;     ///< mm, length of shaft that also touches; with is_round
  bool is_dry = false;  ///< without irrigation

  double radius() const noexcept { return 0.5 * diameter; }
  /// Returns the cutting body. The hand holds its origin (`along` 0): the centre of a ball, of the tip ball
  /// of a match head, or of the end face of a cylinder or barrel.
  volume::ToolBody body() const noexcept;
  static const sim::Schema& schema();
};

/// Returns the radius of the balls with which a round burr touches, mm: the cutting radius minus one step of
/// its offset field, but at least half the cutting radius. Balls of the full radius would have no room in the
/// burr's own hole, because the offset field resolves the axis of the hole only to about one step.
double touch_radius(const Burr& burr, const volume::Volume& volume) noexcept;

/// Returns the surface with which a burr and its shaft touch. The head is slightly smaller than the cutting
/// body, so that a touching burr overlaps bone.
haptics::ToolProfile whole_profile(const Burr& burr, const volume::Volume& anatomy);

/// State of a burr. At the first contact, the body is tangent to the surface on which the proxy rests (a
/// ball: centre = proxy + radius x normal). It then moves toward the HIP as fast as the removal rate allows:
/// its lowest point along the axis of approach ends on the HIP and never passes the HIP. The burr therefore
/// removes matter although the proxy never enters the matter, and the hole depends neither on voxel size nor
/// on servo rate (docs/decisions/0003-the-burr-follows-the-hip.md). A round burr touches with its whole body
/// (haptics::set_tool): it starts at the proxy and moves to the hand at the same rate. A burr without a fixed
/// rate follows a proxy that slides along the surface, and starts again at the proxy if it is farther than a
/// diameter from the segment between proxy and hand.
struct BurrState {
  bool has_centre = false;
  glm::dvec3 centre{0.0};  ///< origin of the body (`along` 0), mm, world frame
  /// Axis of approach: unit vector out of the matter, from the burr's lowest point to its centre. 0 before
  /// contact, and always for a round burr.
  glm::dvec3 axis{0.0};
  glm::dvec3 hip{0.0};               ///< HIP of the last tick, mm, world frame
  double free_mm = 0;                ///< path length of the HIP since the last contact
  double removal_budget_mm3 = 0;     ///< volume that may still be removed; negative after a larger bite
  glm::dvec3 shaft{0.0, 0.0, 1.0};   ///< unit, toward the shaft
  double engaged = 0;                ///< removed volume per path length during the last bites, mm2
  double bite_mm3 = 0, bite_mm = 0;  ///< removed volume and path length since `engaged` was updated

  // Breakthrough.
  glm::dvec3 held_at{0.0}, held_normal{0.0};  ///< last contact that removed bone: mm; unit normal, 0: unset
  glm::dvec3 begun_at{0.0};                   ///< position of the first of these contacts, mm
  double thrust = 0;                          ///< N, smoothed over k_thrust_seconds of contact
  bool is_through = false;                    ///< resistance was lost, and the plunge is measured
  /// Largest depth of the plunge beyond held_at, mm; time since the loss of resistance, and time from the
  /// loss to the deepest point, s.
  double deepest = 0, seconds = 0, deepest_at = 0;

  // Values that are kept when the button is released.
  double rise = 0, hottest = 0;  ///< temperature rise of the bone below the burr, current and largest, K
  static const sim::Schema& schema();
};

/// Loss of resistance, followed by a plunge of the hand. Emitted at the position of the loss, when the plunge
/// ends: the hand returns, touches bone or releases the button, or a second has passed. Pores that the burr
/// passes and plunges of at most 0.5 mm do not count.
struct Breakthrough {
  double thrust = 0;   ///< N, before the breakthrough
  double plunge = 0;   ///< mm beyond the position of the loss
  double seconds = 0;  ///< s, from the loss to the deepest point
  static const sim::Schema& schema();
};

/// Returns the instrument for a hand.
sim::Instrument burr(const Burr& parameters);

/// Returns the forces of a rotating tool.
inline sim::HandForces spin_forces(const haptics::Spin& spin) { return {{haptics::Effect{spin}}, {}}; }

/// Returns the largest temperature rise of bone below the tools that the hands hold, K.
double hottest_bone(const sim::OperationState& operation) noexcept;

/// Module of drilling tools: burr, perforator, craniotome.
class Drilling final : public sim::Module {
 public:
  std::string_view name() const noexcept override { return "drilling"; }
  std::uint32_t version() const noexcept override {
    return 10;
  }  // 10: a perforator reports a hole that was open before
  std::span<const sim::InstrumentType* const> instruments() const override;
  std::span<const sim::ValueType* const> events() const override;
  std::vector<sim::Measure> measures(const sim::OperationState& operation) const override;
  std::vector<sim::Finding> findings(const sim::JobInput& input) const override;
};

}  // namespace trephine::drilling
