// BurrTick: one tick of a rotating cutter, for burrs and the tools that contain one.
#pragma once

#include <functional>
#include <initializer_list>

#include "modules/drilling/burr.h"

namespace trephine::drilling {

/// Returns the unit vector toward the shaft: a stylus points along its own -z.
glm::dvec3 shaft_of(const glm::dquat& hand) noexcept;
/// Returns the shaft of a tool that bone turns away from the hand's orientation (ServoRecord::turn_world).
glm::dvec3 turned(const glm::dvec3& shaft, const glm::dvec3& turn) noexcept;

class BurrTick {
 public:
  /// `body`: the burr's own body, or a replacement.
  BurrTick(const Burr& burr, const volume::ToolBody& body, BurrState& state,
           const sim::InstrumentInput& input, sim::Work& work);
  /// Returns true if the body may move from one pose to another; null: all motions are allowed.
  const std::function<bool(const volume::ToolPose& from, const volume::ToolPose& to)>* is_motion_allowed =
      nullptr;

  void drill();
  /// Updates heat and the detection of breakthroughs.
  void update_heat_and_breakthrough();
  /// Returns the force of the bone on the burr, N.
  double press() const noexcept;

 private:
  bool is_force_controlled() const noexcept { return burr_.removal_rate == 0; }
  Cutting cutting() const noexcept;
  double sweep_to(const volume::ToolPose& pose);
  void turn_axis() noexcept;
  volume::ToolPose pose_at_proxy() const noexcept;
  volume::ToolPose pose_at_hand() const noexcept;
  double travel_between(const volume::ToolPose& from, const volume::ToolPose& to) const noexcept;
  void advance_to(const volume::ToolPose& to, double& limit);
  void follow(double limit);

  const Burr& burr_;
  const volume::ToolBody body_;
  BurrState& state_;
  const haptics::ServoRecord& tick_;
  double dt_;
  sim::Work& work_;
  glm::dvec3 hand_shaft_;
};

/// Returns the ball around a body, at the pose at which it cuts or touches.
sim::ToolBall ball_around(const Burr& burr, const volume::ToolBody& body, const BurrState& state,
                          const sim::InstrumentInput& input);
/// Returns an error if a body cannot touch and cut in a scene.
Status check_body(const volume::ToolBody& body, bool is_round, const haptics::TouchScene& scene);
/// Returns an error unless the scene has the contact balls that a tool needs. Smaller balls would let the
/// tool into bone that it has not cut.
Status check_touch(const sim::ToolNeeds& needs, const haptics::TouchScene& scene, const char* tool);
/// Returns the fields of a table, followed by more.
std::vector<sim::Field> joined(std::span<const sim::Field> first, std::initializer_list<sim::Field> more);

}  // namespace trephine::drilling
