// A spherical burr: bone is removed where the ball sweeps, at a rate that the drill can do.
#pragma once

#include "sim/session_format.h"
#include "sim/tool.h"

namespace trephine::drilling {

struct BurrOptions {
  double radius = 2;  ///< mm
  double removal_rate =
      30;                  ///< mm^3/s that the burr can take away in contact, until the physical rate exists
  double feed_limit = 40;  ///< mm/s, the ball's fastest way through matter
  bool is_kinematic = false;  ///< the pose is the ball's centre; everything it sweeps goes, touched or not
  bool is_round = false;      ///< the hand holds the ball's centre, and the scene's tool has its radius
  double smallest = 0;        ///< mm, diameter: a smaller one would leave no hole in the session's lattice

  /// As recordings name it.
  sim::ToolSpec spec() const;
};

/// Of the ball that touches in place of a round burr, mm: a step of its offset field less than it cuts, so
/// that it has room in its own hole, whose axis that field does not resolve finer.
double touch_radius(const BurrOptions& options, const volume::Volume& volume) noexcept;

/// In contact the ball starts tangent to the surface on which the proxy rests (centre = proxy + radius
/// normal) and sinks toward the HIP as fast as the removal rate allows: its lowest point, seen along the axis
/// of approach, ends on the HIP and never passes it. So a proxy that never enters matter still removes it,
/// and the hole depends neither on voxel size nor on servo rate
/// (docs/decisions/0003-the-burr-follows-the-hip.md). A round one is touched with all of its ball
/// (haptics::set_tool_radius): its centre starts at the proxy and moves toward the HIP, by the same rate. The
/// physical rate replaces `budget()` when it comes.
class Burr final : public sim::Tool {
 public:
  explicit Burr(const BurrOptions& options) : options_(options) {}

  volume::RemovalReport apply(const haptics::ServoRecord& tick, double dt,
                              volume::RemovalEditor& editor) override;
  void lift() override;
  /// "diameter" and "feed_limit" (mm, mm/s), "removal_rate" (mm^3/s), "is_kinematic", "is_round" (0 or 1).
  bool set(std::string_view name, double value) override;

  const BurrOptions& options() const noexcept { return options_; }
  /// Where the ball is, world frame; meaningful while has_centre().
  const glm::dvec3& centre() const noexcept { return centre_; }
  bool has_centre() const noexcept { return has_centre_; }

 private:
  /// mm^3 that `dt` seconds of contact can take away.
  double budget(double dt) const noexcept { return options_.removal_rate * dt; }
  void turn_axis(const haptics::ServoRecord& tick, double dt) noexcept;
  double sweep_to(const glm::dvec3& centre_world, volume::RemovalEditor& editor,
                  volume::RemovalReport& report);

  BurrOptions options_;
  bool has_centre_ = false;
  glm::dvec3 centre_{0.0};
  glm::dvec3 axis_{
      0.0};  ///< unit, out of the matter: from the ball's lowest point to its centre; 0 before contact
  glm::dvec3 hip_{0.0};
  double free_mm_ = 0;   ///< way of the HIP since the last contact
  double owed_mm3_ = 0;  ///< removal that time has paid for; negative after a bite larger than that
};

}  // namespace trephine::drilling
