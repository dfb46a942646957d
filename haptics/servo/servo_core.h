// ServoCore: computes proxy and force of one hand from its pose, once per tick. The live loop, lockstep and
// replay use it.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "haptics/force/force.h"
#include "haptics/force/passivity.h"
#include "haptics/servo/servo_record.h"
#include "haptics/servo/servo_scene.h"

namespace trephine::haptics {

/// Returns the frame of a hand, in which the meshes that it holds are fixed.
Placement placement_of(const Pose& pose) noexcept;
/// Placement of each hand in the previous tick, if known.
using HandPlacements = std::array<std::optional<Placement>, ServoScene::k_max_hands>;

/// Input of a tick.
struct ServoInput {
  Pose pose;
  std::uint32_t faults = 0;  ///< raised outside the core; latched ones stay until a reset
  bool is_reset = false;     ///< the tick begins with reset()
  bool is_restarted = false;
  glm::dvec3 restart_volume{0.0};  ///< free point at which the proxy starts again, if is_restarted
  const HandPlacements* hand_placements = nullptr;  ///< of all hands, for held meshes; null: unknown
};

/// Escape of a buried proxy. A path of 10 mm, as long as a burr hole is deep, takes a tenth of a second. The
/// force is so small that a resting hand can resist it.
inline constexpr double k_escape_speed = 100;    ///< mm/s
inline constexpr double k_escape_force = 3;      ///< N
inline constexpr double k_escape_recovery = 10;  ///< N/s, rise of the force limit after an escape

/// Proxy and force of one hand. Plain data: a copy saves the complete state.
class ServoCore {
 public:
  /// `hand`: index of the hand in ServoScene::hands.
  explicit ServoCore(const ForceOptions& options, double dt, std::size_t hand = 0,
                     std::uint64_t first_tick = 0);

  /// Runs one tick. An invalid pose gives no force and latches a fault. If the scene has a new escape path, a
  /// proxy that the restored matter buries follows it, and so does a proxy that is already on an escape path.
  /// Servo thread.
  ServoRecord step(const ServoScene& servo_scene, const ServoInput& input) noexcept;
  /// Skips ticks that cannot be recorded: the proxy stays, the force continues to fade. Returns the wrench to
  /// render.
  Wrench skip(std::uint32_t faults, std::uint64_t count = 1) noexcept;
  /// Sets the proxy to a free point (volume frame); the force starts from zero.
  void restart_at(const glm::dvec3& free_point_volume) noexcept;
  /// Clears force, latched faults, and the memory of laws; the force limit rises from zero. The proxy stays,
  /// because the hand may be deep in bone. A proxy that follows an escape path starts again at the HIP.
  void reset() noexcept;
  std::uint32_t faults() const noexcept { return guard_.faults(); }

  std::uint64_t next_tick() const noexcept { return tick_; }
  /// Returns the placement of the hand in the last tick before `tick`; empty while no mesh is held.
  std::optional<Placement> pose_before(std::uint64_t tick) const noexcept;
  const ProxyStep& last_step() const noexcept { return step_; }
  const ProxyState& proxy_state() const noexcept { return state_; }
  const EnergyLedger& energy() const noexcept { return energy_; }

 private:
  friend struct ServoMemory;
  friend struct ForceParts force_parts(const ServoCore&, const ServoScene&, const ServoInput&);
  /// Visits the state that changes from tick to tick, field by field, for saving.
  template <class Fields>
  void each_field(Fields& fields) {
    fields(layout_, force_, guard_, state_, step_, tick_, touched_item_, requested_.force_world,
           active_force_, requested_.torque_world, escape_path_, is_escaping_, is_fresh_, next_position_,
           anchor_volume_, force_cap_, laws_, passivity_, not_ready_, reported_not_ready_, last_shape_,
           popped_shape_, popped_side_, popped_at_world_, energy_, last_.force_world, last_.torque_world,
           last_turn_, last_active_, last_normal_, last_position_, had_position_, was_escaping_, is_turning_,
           has_recent_poses_, recent_poses_);
  }
  void limit_energy(const glm::dvec3& hip, const glm::dquat& orientation, bool is_six_dof) noexcept;
  ProxyStep step_with_held(const ServoHand& hand, const ServoInput& input) noexcept;
  void remember_pose(const ServoScene& servo_scene, const ServoRecord& record) noexcept;
  ServoRecord step_without_hand(const ServoScene& servo_scene, const ServoInput& input) noexcept;
  void adopt(const ServoHand& hand) noexcept;
  void release_proxy() noexcept;
  void begin_escape(const ServoHand& hand, const glm::dvec3& hip_world) noexcept;
  void escape(const ServoHand& hand, const glm::dvec3& hip_world) noexcept;
  Wrench passive_part(const Wrench& rendered) const noexcept;
  void account(const ServoRecord& record) noexcept;
  void account_motion(const glm::dvec3& motion) noexcept;
  void pop_through(const ServoHand& hand, const glm::dvec3& hip_world, ServoRecord& record) noexcept;
  void emit_events(ServoRecord& record) noexcept;
  double time() const noexcept { return static_cast<double>(tick_) * dt_; }
  void update_passable_items(const ServoHand& hand) noexcept;

  ForceModel force_;
  ForceGuard guard_;
  double dt_, force_limit_;
  std::size_t hand_;
  std::uint64_t layout_ = 0;  ///< ServoHand::layout to which `state_` belongs
  ProxyState state_;
  ProxyStep step_;
  std::uint64_t tick_ = 0;
  int touched_item_ = 0;  ///< item of the latest contact
  Wrench requested_;
  glm::dvec3 active_force_{0.0};  ///< part of requested_

  EscapePath escape_path_;  ///< the latest adopted path
  bool is_escaping_ = false, is_fresh_ = true;
  std::uint32_t next_position_ = 0;  ///< index of the next position on escape_path_
  glm::dvec3 anchor_volume_{0.0};    ///< proxy during an escape
  double force_cap_;                 ///< N, limit of the force during and after an escape

  LawMemory laws_;
  PassivityController passivity_;
  bool is_passive_;
  ShapeSet not_ready_, reported_not_ready_;
  int last_shape_ = -1;    ///< item touched in the previous tick; -1: no contact
  int popped_shape_ = -1;  ///< item that was pressed through and is not rearmed yet; -1: no item
  Side popped_side_ = Side::front;
  glm::dvec3 popped_at_world_{0.0};

  EnergyLedger energy_;
  Wrench last_;  ///< rendered in the previous tick
  glm::dvec3 last_active_{0.0}, last_normal_{0.0}, last_position_{0.0};
  glm::dquat last_turn_{1, 0, 0, 0};
  bool had_position_ = false, was_escaping_ = false;
  bool is_turning_ = false;  ///< a torque is requested, or still rendered

  /// Placements of the hand in the two latest ticks with a valid pose, newest first. Kept while a mesh is
  /// held.
  struct RecentPose {
    Placement pose;
    std::uint64_t tick = 0;
    bool is_known = false;
    template <class Fields>
    void each_field(Fields& fields) {
      fields(pose.position_world, pose.rotation, tick, is_known);
    }
  };
  std::array<RecentPose, 2> recent_poses_;
  bool has_recent_poses_ = false;
};

/// Returns the placement of each core's hand before `tick`. Call before any of the cores runs this tick.
template <class Cores>
HandPlacements placements_before(const Cores& cores, std::uint64_t tick) noexcept {
  HandPlacements all;
  for (std::size_t h = 0; h < cores.size(); ++h) all[h] = cores[h].pose_before(tick);
  return all;
}

/// Flushes denormals to zero on this thread during its lifetime, as servo threads do, so that a replay
/// computes the same bits.
class DenormalsFlushed {
 public:
  DenormalsFlushed() noexcept;
  ~DenormalsFlushed();
  DenormalsFlushed(const DenormalsFlushed&) = delete;
  DenormalsFlushed& operator=(const DenormalsFlushed&) = delete;

 private:
  unsigned saved_control_;
};

}  // namespace trephine::haptics
