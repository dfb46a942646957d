// ServoRecord: input and output of one servo tick, for edits, recordings and displays.
#pragma once

#include <array>
#include <cstdint>

#include "haptics/device/pose_path.h"
#include "haptics/device/wrench.h"
#include "haptics/force/faults.h"
#include "haptics/scene/touch_scene.h"

namespace trephine::haptics {

/// Work done on the hand, N mm: the sum of F_k (x_{k+1} - x_k) over the ticks. The force F_k is constant from
/// tick k to the next (passivity observer, Hannaford & Ryu 2002).
struct EnergyLedger {
  double contact = 0;    ///< by surfaces with friction, after smoothing, and by laws that create no energy
  double friction = 0;   ///< part of `contact` along the surface
  double active = 0;     ///< by laws that may create energy; their power is at most LawMemory::k_power
  double turning = 0;    ///< by torques
  double growth = 0;     ///< while the proxy was led out of restored matter
  double discarded = 0;  ///< never rendered: energy of springs from the hand to the ends of escape paths
};

/// Event detected in a tick.
struct TouchEvent {
  enum Kind : std::uint8_t {
    touched,          ///< the proxy touches a shape that it did not touch in the previous tick
    untouched,        ///< a shape is no longer touched
    popped,           ///< the tool was pressed through a shape
    rearmed,          ///< a popped shape may block again
    not_ready,        ///< a touchable item cannot block: its data around the hand are not available yet
    ready,            ///< an item that was not ready can block
    lost_resistance,  ///< a track left its tissue (haptics/force/effects.h)
    met_resistance,   ///< a track entered a tissue
  } kind = touched;
  std::int16_t shape = -1;
};
/// Returns the name for messages and reports: "touched", "popped", ...
const char* event_name(TouchEvent::Kind kind) noexcept;

/// Record of one tick, for the edit thread, recordings and displays. Contains input and output, so that the
/// tick can be run again.
struct ServoRecord {
  std::uint64_t tick = 0;
  double t = 0;               ///< s since the start
  std::uint64_t version = 0;  ///< serial of the tick's ServoScene
  Pose pose;                  ///< no buttons and axes while a fault is latched or the proxy is led out
  glm::dvec3 proxy_world{0.0}, normal_world{0.0}, force_world{0.0};  ///< mm, unit, N
  glm::dvec3 torque_world{0.0};                                      ///< N mm
  glm::dvec3 contact_force_world{0.0};  ///< N, by surfaces only, before passivity controller and final limits
  glm::dvec3 turn_world{0.0};           ///< rad, rotation from the hand to the tool; see turn_between()
  bool has_contact = false, is_buried = false;
  bool is_escaping = false;  ///< the proxy is led out of restored matter
  int shape = -1;            ///< the touched item
  Side side = Side::none;
  std::uint32_t faults = 0;  ///< latched faults, and faults of this tick
  std::uint32_t raised = 0;  ///< ServoInput::faults, and faults of an invalid pose or a missing hand
  bool is_reset = false, is_restarted = false;
  glm::dvec3 restart_volume{0.0};  ///< see ServoInput; valid if is_restarted
  std::uint8_t hand = 0;           ///< index of the hand
  EnergyLedger energy;             ///< since the start
  Wrench wrench() const noexcept { return {force_world, torque_world}; }
  static constexpr std::size_t k_max_events = 6;
  std::uint8_t event_count = 0;  ///< further events are dropped
  std::array<TouchEvent, k_max_events> events;
};

}  // namespace trephine::haptics
