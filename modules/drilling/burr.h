// Burrs: bone is removed where the turning body sweeps, as fast as press, speed and bone have it.
#pragma once

#include "modules/drilling/cutting.h"
#include "sim/module.h"

namespace trephine::drilling {

enum class Shape : std::uint8_t { sphere, cylinder, barrel, match_head };

/// Its parameters.
struct Burr {
  double diameter = 4;      ///< mm, where it is widest
  double removal_rate = 0;  ///< mm^3/s that it can take away in contact; 0: by the press (drilling/cutting.h)
  double feed_limit = 40;   ///< mm/s, the burr's fastest way through matter
  bool is_kinematic = false;  ///< the pose is the burr's own; everything it sweeps goes, touched or not
  bool is_round = false;      ///< the hand holds the burr, and touches with all of it
  Shape shape = Shape::sphere;
  Grade grade = Grade::cutting;
  double rpm = 60000;   ///< of the spindle
  double length = 0;    ///< mm, of a burr that is no ball; 0: as usual for its shape
  double shaft = 0;     ///< mm of shaft behind it that are touched too, as thick as its end; with is_round
  bool is_dry = false;  ///< not irrigated

  double radius() const noexcept { return 0.5 * diameter; }
  /// Cutting body. The hand holds its `along` 0: the middle of a ball, of the tip ball of a match head,
  /// of the end face of the others.
  volume::ToolBody body() const noexcept;
  static const sim::Schema& schema();
};

/// Balls that touch in place of a round burr, mm: a step of its offset field less than it cuts, so
/// that it has room in its own hole, whose axis that field does not resolve finer.
double touch_radius(const Burr& burr, const volume::Volume& volume) noexcept;

/// Pose of a burr. In contact it starts tangent to the surface on which the proxy rests (of a ball: centre =
/// proxy + radius normal) and sinks toward the HIP as fast as the removal rate allows: its lowest point, seen
/// along the axis of approach, ends on the HIP and never passes it. So a proxy that never enters matter still
/// removes it, and the hole depends neither on voxel size nor on servo rate
/// (docs/decisions/0003-the-burr-follows-the-hip.md). A round one is touched with all of it
/// (haptics::set_tool): it starts where the proxy is and moves to where the hand is, by the same rate. One
/// that goes by the press starts again where the proxy is, when that slid away from it.
struct BurrState {
  bool has_centre = false;
  glm::dvec3 centre{0.0};  ///< where its `along` is 0, world frame
  glm::dvec3 axis{
      0.0};  ///< unit, out of the matter: from the burr's lowest point to its middle; 0 before contact
  glm::dvec3 hip{0.0};
  double free_mm = 0;   ///< way of the HIP since the last contact
  double owed_mm3 = 0;  ///< removal that time has paid for; negative after a bite larger than that
  glm::dvec3 shaft{0.0, 0.0, 1.0};   ///< unit, toward the shaft
  double engaged = 0;                ///< mm2 that were in the bone in the last bites
  double bite_mm3 = 0, bite_mm = 0;  ///< of bites since, and their way

  // Breakthrough.
  glm::dvec3 held_at{0.0}, held_normal{0.0};        ///< of the last contact in which it cut; normal 0: none
  glm::dvec3 begun_at{0.0};                         ///< of the first of them
  double thrust = 0;                                ///< N, smoothed over k_thrust_seconds of contact
  bool is_through = false;                          ///< resistance was lost, and the hand goes on
  double deepest = 0, seconds = 0, deepest_at = 0;  ///< mm beyond held_at; s since; s when deepest

  // Total of its work; stays when the button is let go.
  double rise = 0, hottest = 0;  ///< K, of the bone under it
  static const sim::Schema& schema();
};

/// Resistance was lost and the hand went on: emitted when it stopped, with the place where it was lost. Pores
/// that the burr passes do not count.
struct Breakthrough {
  double thrust = 0;   ///< N, before
  double plunge = 0;   ///< mm beyond
  double seconds = 0;  ///< until then
  static const sim::Schema& schema();
};

/// The instrument, for a hand.
sim::Instrument burr(const Burr& parameters);

/// Module of drilling tools: the burr.
class Drilling final : public sim::Module {
 public:
  std::string_view name() const noexcept override { return "drilling"; }
  std::uint32_t version() const noexcept override { return 4; }  // 4: a craniotome's foot is blunt
  std::span<const sim::InstrumentType* const> instruments() const override;
  std::span<const sim::ValueType* const> events() const override;
  std::vector<sim::Measure> measures(const sim::OperationState& now) const override;
};

}  // namespace trephine::drilling
