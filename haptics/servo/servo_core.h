// The work of one servo tick: pose in, proxy and force out. Shared by the live loop, lockstep and replay.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "haptics/device/pose_path.h"
#include "haptics/device/wrench.h"
#include "haptics/force/force.h"
#include "haptics/force/passivity.h"
#include "haptics/servo/servo_scene.h"

namespace trephine::haptics {

/// Work done on the hand, N mm: the sum of F_k (x_{k+1} - x_k) over the holds (passivity observer, Hannaford
/// & Ryu 2002).
struct EnergyLedger {
  double contact = 0;    ///< surfaces, friction, what smoothing leaves of them, and springs and dampers
  double friction = 0;   ///< of contact: the part along the surface
  double active = 0;     ///< laws that may give energy; at most LawMemory::k_power
  double turning = 0;    ///< of torques
  double growth = 0;     ///< while the proxy was led out of matter that grew
  double discarded = 0;  ///< stored by growth in the spring, had the proxy jumped out; never rendered
};

/// Something that a tick noticed.
struct TouchEvent {
  enum Kind : std::uint8_t {
    touched,          ///< a shape, that was not in the tick before
    untouched,        ///< a shape is touched no more
    popped,           ///< pressed through a shape
    rearmed,          ///< a shape that was pressed through may hold again
    not_ready,        ///< a shape that is wanted cannot hold: its bits are not there yet
    ready,            ///< now it can
    lost_resistance,  ///< a track left its tissue (haptics/force/effects.h)
  } kind = touched;
  std::int16_t shape = -1;
};
/// For people and reports: "touched", "popped", ...
const char* event_name(TouchEvent::Kind kind) noexcept;

/// Record of one tick, for the edit thread, recordings and displays. Input and output: a tick can be run
/// again.
struct ServoRecord {
  std::uint64_t tick = 0;
  double t = 0;               ///< s since the start
  std::uint64_t version = 0;  ///< serial of the ServoScene that the tick saw
  Pose pose;                  ///< no button while a fault is latched or the proxy is led out
  glm::dvec3 proxy_world{0.0}, normal_world{0.0}, force_world{0.0};
  glm::dvec3 torque_world{0.0};  ///< N mm
  glm::dvec3 press_world{0.0};   ///< N, of surfaces alone, before fades and limits of the whole
  glm::dvec3 turn_world{0.0};    ///< as turn_between() gives it, from the hand to a tool of several balls
  bool has_contact = false, is_buried = false;
  bool is_led = false;  ///< matter grew over the proxy and it is on its way out
  int shape = -1;       ///< the touched item
  Side side = Side::none;
  std::uint32_t faults = 0;
  std::uint32_t raised = 0;  ///< faults seen outside this tick's work: an input
  bool is_reset = false, is_restarted = false;
  glm::dvec3 restart_volume{0.0};  ///< meaningful when restarted
  std::uint8_t hand = 0;
  EnergyLedger energy;  ///< since the start
  Wrench wrench() const noexcept { return {force_world, torque_world}; }
  static constexpr std::size_t k_most_events = 6;
  std::uint8_t event_count = 0;  ///< those beyond the array are dropped
  std::array<TouchEvent, k_most_events> events;
};

/// The frame of a hand, as a thing that it holds sees it.
Placement place_of(const Pose& pose) noexcept;
/// Position of each hand in the previous tick, where known.
using HandPlaces = std::array<std::optional<Placement>, ServoScene::k_most_hands>;

/// Input of a tick.
struct ServoInput {
  Pose pose;
  std::uint32_t faults = 0;  ///< seen outside: latched ones stay raised until a reset
  bool is_reset = false;     ///< forget everything first
  bool is_restarted = false;
  glm::dvec3 restart_volume{0.0};      ///< then set the proxy on this free point, the force from zero
  const HandPlaces* places = nullptr;  ///< for what hands hold; null: none is known
};

/// Escape of a buried proxy: in tenths of a second over the length of a burr hole, with less force than a
/// resting hand holds against.
inline constexpr double k_lead_speed = 100;    ///< mm/s
inline constexpr double k_lead_force = 3;      ///< N
inline constexpr double k_lead_recovery = 10;  ///< N/s, at which the full force comes back afterwards

/// Holds all state of the feel; plain data, so that a copy saves it.
class ServoCore {
 public:
  /// `hand`: whose of a ServoScene's this is.
  explicit ServoCore(const ForceOptions& options, double dt, std::size_t hand = 0,
                     std::uint64_t first_tick = 0);

  /// Servo thread. A pose that is no place gives no force and a latched fault. When a scene with a way out is
  /// first seen, a proxy that its matter buries, or that is being led, goes this way.
  ServoRecord step(const ServoScene& seen, const ServoInput& input) noexcept;
  /// Steps through ticks that cannot be recorded: the proxy stays, the force goes on fading. Returns the
  /// output.
  Wrench skip(std::uint32_t faults, std::uint64_t count = 1) noexcept;
  void restart_at(const glm::dvec3& free_point_volume) noexcept;
  void reset() noexcept;

  std::uint64_t next_tick() const noexcept { return tick_; }
  /// Position of the hand in the previous tick; empty while no hand is held.
  std::optional<Placement> place_before(std::uint64_t tick) const noexcept;
  const ProxyStep& last_step() const noexcept { return step_; }
  const ProxyState& proxy_state() const noexcept { return state_; }
  const EnergyLedger& energy() const noexcept { return energy_; }

 private:
  friend struct ServoMemory;
  /// All that changes from tick to tick.
  template <class Fields>
  void each_field(Fields& fields) {
    fields(layout_, force_, guard_, state_, step_, tick_, touched_, wanted_, active_, torque_, way_, is_led_,
           is_fresh_, next_place_, anchor_volume_, cap_, laws_, passivity_, not_ready_, told_not_ready_,
           last_shape_, popped_shape_, popped_side_, popped_at_world_, energy_, last_force_, last_torque_,
           last_turn_, last_active_, last_normal_, last_position_, had_position_, was_led_, is_turning_,
           knows_place_, places_);
  }
  ProxyStep step_with_held(const ServoHand& mine, const ServoInput& input) noexcept;
  void remember_place(const ServoScene& seen, const ServoRecord& record) noexcept;
  ServoRecord without_scene(const ServoScene& seen, const ServoInput& input) noexcept;
  void adopt(const ServoHand& mine) noexcept;
  void let_go() noexcept;
  void begin_lead(const ServoHand& mine, const glm::dvec3& hip_world) noexcept;
  void lead(const ServoHand& mine, const glm::dvec3& hip_world) noexcept;
  glm::dvec3 passive_part(const glm::dvec3& rendered) const noexcept;
  void account(const ServoRecord& record) noexcept;
  void account_motion(const glm::dvec3& moved) noexcept;
  void account_turn(const ServoRecord& record, bool goes_on) noexcept;
  void pop_through(const ServoHand& mine, const glm::dvec3& hip_world, ServoRecord& record) noexcept;
  void emit_events(ServoRecord& record) noexcept;
  void find_ready(const ServoHand& mine, const glm::dvec3& hip_world) noexcept;
  void find_depths_ready(const ServoHand& mine, const glm::dvec3& hip_world, double farthest) noexcept;
  double time() const noexcept { return static_cast<double>(tick_) * dt_; }
  void let_through_what_is_off(const ServoHand& mine) noexcept;

  ForceModel force_;
  ForceGuard guard_;
  double dt_, force_limit_;
  std::size_t hand_;
  std::uint64_t layout_ = 0;  ///< that `state_` knows
  ProxyState state_;
  ProxyStep step_;
  std::uint64_t tick_ = 0;
  int touched_ = 0;  ///< item of the newest contact
  glm::dvec3 wanted_{0.0}, active_{0.0}, torque_{0.0};

  WayOut way_;  ///< the newest that was seen
  bool is_led_ = false, is_fresh_ = true;
  std::uint32_t next_place_ = 0;
  glm::dvec3 anchor_volume_{0.0};
  double cap_;  ///< N, of the force after a lead

  LawMemory laws_;
  PassivityController passivity_;
  bool is_passive_;
  ShapeSet not_ready_, told_not_ready_;
  int last_shape_ = -1;    ///< touched in the last tick
  int popped_shape_ = -1;  ///< pressed through, and not yet armed again
  Side popped_side_ = Side::front;
  glm::dvec3 popped_at_world_{0.0};

  EnergyLedger energy_;
  glm::dvec3 last_force_{0.0}, last_active_{0.0}, last_normal_{0.0}, last_position_{0.0};
  glm::dvec3 last_torque_{0.0};
  glm::dquat last_turn_{1, 0, 0, 0};
  bool had_position_ = false, was_led_ = false;
  bool is_turning_ = false;  ///< some law turns the stylus, or its torque goes on

  /// While some hand holds a thing: the newest, and the one before.
  struct Place {
    Placement where;
    std::uint64_t tick = 0;
    bool is_known = false;
    template <class Fields>
    void each_field(Fields& fields) {
      fields(where.position_world, where.rotation, tick, is_known);
    }
  };
  std::array<Place, 2> places_;
  bool knows_place_ = false;
};

/// Places of the hands of several cores before a tick of any of them.
template <class Cores>
HandPlaces places_before(const Cores& cores, std::uint64_t tick) noexcept {
  HandPlaces all;
  for (std::size_t h = 0; h < cores.size(); ++h) all[h] = cores[h].place_before(tick);
  return all;
}

/// While it lives, this thread flushes denormals to zero, as a servo thread does: the same bits in a replay.
class DenormalsFlushed {
 public:
  DenormalsFlushed() noexcept;
  ~DenormalsFlushed();
  DenormalsFlushed(const DenormalsFlushed&) = delete;
  DenormalsFlushed& operator=(const DenormalsFlushed&) = delete;

 private:
  unsigned before_;
};

}  // namespace trephine::haptics
