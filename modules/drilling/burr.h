// A spherical burr: bone is removed where the ball sweeps, at a rate that the drill can do.
#pragma once

#include "sim/module.h"

namespace trephine::drilling {

/// Its parameters.
struct Burr {
  double diameter = 4;        ///< mm
  double removal_rate = 30;   ///< mm^3/s that it can take away in contact, until the physical rate exists
  double feed_limit = 40;     ///< mm/s, the ball's fastest way through matter
  bool is_kinematic = false;  ///< the pose is the ball's centre; everything it sweeps goes, touched or not
  bool is_round = false;      ///< the hand holds the ball's centre, and its tool has the ball's radius

  double radius() const noexcept { return 0.5 * diameter; }
  static const sim::Schema& schema();
};

/// Of the ball that touches in place of a round burr, mm: a step of its offset field less than it cuts, so
/// that it has room in its own hole, whose axis that field does not resolve finer.
double touch_radius(const Burr& burr, const volume::Volume& volume) noexcept;

/// Where a burr is. In contact the ball starts tangent to the surface on which the proxy rests (centre =
/// proxy
/// + radius normal) and sinks toward the HIP as fast as the removal rate allows: its lowest point, seen along
/// the axis of approach, ends on the HIP and never passes it. So a proxy that never enters matter still
/// removes it, and the hole depends neither on voxel size nor on servo rate
/// (docs/decisions/0003-the-burr-follows-the-hip.md). A round one is touched with all of its ball
/// (haptics::set_tool_radius): its centre starts at the proxy and moves toward the HIP, by the same rate. The
/// physical rate replaces `budget()` when it comes.
struct BurrState {
  bool has_centre = false;
  glm::dvec3 centre{0.0};  ///< of the ball, world frame
  glm::dvec3 axis{
      0.0};  ///< unit, out of the matter: from the ball's lowest point to its centre; 0 before contact
  glm::dvec3 hip{0.0};
  double free_mm = 0;   ///< way of the HIP since the last contact
  double owed_mm3 = 0;  ///< removal that time has paid for; negative after a bite larger than that
  static const sim::Schema& schema();
};

/// The instrument, for a hand.
sim::Instrument burr(const Burr& parameters);

/// What drilling adds to an operation: the burr.
class Drilling final : public sim::Module {
 public:
  std::string_view name() const noexcept override { return "drilling"; }
  std::span<const sim::InstrumentType* const> instruments() const override;
};

}  // namespace trephine::drilling
