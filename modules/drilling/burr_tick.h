// One tick of whatever turns and cuts: burrs, and the tools that are made of one.
#pragma once

#include <functional>
#include <initializer_list>

#include "modules/drilling/burr.h"

namespace trephine::drilling {

/// Unit, toward the shaft: a stylus points along its own -z.
glm::dvec3 shaft_of(const glm::dquat& hand) noexcept;
/// Turn of a tool that the bone turns out of the hand's way (ServoRecord::turn_world).
glm::dvec3 turned(const glm::dvec3& shaft, const glm::dvec3& turn) noexcept;

class BurrTick {
 public:
  /// `body`: the burr's own, or what it is in place of that.
  BurrTick(const Burr& burr, const volume::ToolBody& body, BurrState& state,
           const sim::InstrumentInput& input, sim::Work& work);
  /// Test of places that it may not enter; null: it may go anywhere.
  const std::function<bool(const volume::ToolPlace& from, const volume::ToolPlace& to)>* may_go = nullptr;

  void drill();
  /// Consequences of the tick in addition to the cut: heat, and loss of resistance.
  void cool_and_watch();
  /// N, of bone on the burr.
  double press() const noexcept;

 private:
  bool is_by_press() const noexcept { return burr_.removal_rate == 0; }
  Cutting cutting() const noexcept;
  double sweep_to(const volume::ToolPlace& place);
  void turn_axis() noexcept;
  volume::ToolPlace place_at_proxy() const noexcept;
  volume::ToolPlace place_at_hand() const noexcept;
  double way_between(const volume::ToolPlace& from, const volume::ToolPlace& to) const noexcept;
  void go_to(const volume::ToolPlace& to, double& limit);
  void follow(double limit);

  const Burr& burr_;
  const volume::ToolBody body_;
  BurrState& state_;
  const haptics::ServoRecord& tick_;
  double dt_;
  sim::Work& work_;
  glm::dvec3 hand_shaft_;
};

/// The ball around a body while it cuts, and where it touches.
sim::ToolBall ball_around(const Burr& burr, const volume::ToolBody& body, const BurrState& state,
                          const sim::InstrumentInput& input);
/// Can such a body be touched and cut with here?
volume::Status check_body(const volume::ToolBody& body, bool is_round, const haptics::TouchScene& scene);
/// Is it touched here with the balls that it needs? A smaller one lets it into bone that it has not cut.
volume::Status check_touch(const sim::ToolNeeds& needs, const haptics::TouchScene& scene, const char* tool);
/// A table that goes on after another's fields.
std::vector<sim::Field> joined(std::span<const sim::Field> first, std::initializer_list<sim::Field> more);

}  // namespace trephine::drilling
