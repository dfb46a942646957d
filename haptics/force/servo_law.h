// ServoLaw: force in addition to those of surfaces. It is a function of a module, which the servo calls in
// every tick. Instruments do not compute forces, since they run some ticks later; they set the parameters of
// laws.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <type_traits>
#include <vector>

#include "haptics/device/pose_path.h"
#include "haptics/proxy/proxy_step.h"

namespace trephine::haptics {

/// Input of a law.
struct LawInput {
  const TouchScene& scene;
  const volume::Version* cuts;  ///< of the scene's base; null: uncut
  const ProxyStep& proxy;
  glm::dvec3 contact_force_world;   ///< N, of the surfaces in this tick
  glm::dvec3 contact_torque_world;  ///< N mm, of the surfaces in this tick, about the hand
  glm::dvec3 hip_world;
  glm::dquat orientation;             ///< of the hand
  glm::dvec3 velocity_world;          ///< mm/s, of the hand, smoothed
  glm::dvec3 angular_velocity_world;  ///< rad/s, of the hand, smoothed
  double dt;                          ///< s since the previous tick
  bool is_working;                    ///< the button is pressed
};

/// Sum of the laws of a hand.
struct LawForces {
  glm::dvec3 passive_world{0.0};     ///< N, of springs and dampers, which store or dissipate energy
  glm::dvec3 active_world{0.0};      ///< N, of laws that may create energy
  glm::dvec3 torque_world{0.0};      ///< N mm, of springs and dampers
  bool has_lost_resistance = false;  ///< a tip left the matter that resisted its track
  int exited_shape = -1;             ///< the item of that matter; -1: a label
  bool has_met_resistance = false;   ///< a tip entered matter that resists its track
  int entered_shape = -1;            ///< the item of that matter; -1: a label
  bool has_tip = false;              ///< a law holds the tip
  glm::dvec3 tip_world{0.0};         ///< its position, which replaces that of the proxy in the record
};

/// A law of one hand, made by make_law(). Immutable when published.
struct ServoLaw {
  static constexpr std::size_t k_memory = 256;  ///< bytes that a law may keep between ticks
  std::uint32_t id = 0;  ///< unique within its hand; the memory stays with it when parameters change
  using Step = void (*)(const void* parameters, void* memory, const LawInput& input, LawForces& sum) noexcept;
  Step step = nullptr;
  std::shared_ptr<const void> parameters;
  std::string words = {};  ///< its definition as text, for judges and users
};

/// Makes a law from `void step(const Parameters&, Memory&, const LawInput&, LawForces& sum) noexcept`, which
/// adds to the sum. Servo thread: no allocation, lock or wait; the law itself bounds its forces. A Memory is
/// plain data and starts as zeros.
template <auto k_step>
struct LawOf;
template <class Parameters, class Memory,
          void (*k_step)(const Parameters&, Memory&, const LawInput&, LawForces&) noexcept>
struct LawOf<k_step> {
  static_assert(std::is_trivially_copyable_v<Memory> && sizeof(Memory) <= ServoLaw::k_memory &&
                alignof(Memory) <= alignof(std::max_align_t));
  static ServoLaw make(std::uint32_t id, Parameters parameters) {
    return {id,
            [](const void* p, void* memory, const LawInput& input, LawForces& sum) noexcept {
              k_step(*static_cast<const Parameters*>(p), *static_cast<Memory*>(memory), input, sum);
            },
            std::make_shared<const Parameters>(std::move(parameters)),
            {}};
  }
};
template <auto k_step, class Parameters>
ServoLaw make_law(std::uint32_t id, Parameters parameters) {
  return LawOf<k_step>::make(id, std::move(parameters));
}

/// The laws of one hand. Immutable when published.
class LawSet {
 public:
  static constexpr std::size_t k_max = 8;
  /// Error if the set is full or contains a law with this id.
  Status add(ServoLaw law);
  const std::vector<ServoLaw>& laws() const noexcept { return laws_; }

 private:
  std::vector<ServoLaw> laws_;
};

/// Memory of the laws of one hand, by their ids. Plain data, so that a copy saves it.
class LawMemory {
 public:
  static constexpr double k_power = 500;  ///< N mm/s: largest power of active laws on a moving hand

  /// Runs the laws, once per tick; sets the velocities of the input. The memory of a new law starts as zeros,
  /// that of a removed one is discarded. Servo thread.
  LawForces step(const LawSet& set, LawInput input) noexcept;
  /// Clears motion and memories.
  void reset() noexcept { count_ = 0, has_last_ = false, velocity_ = turning_ = glm::dvec3(0); }
  bool is_empty() const noexcept { return count_ == 0 && !has_last_; }
  /// Visits the complete state, field by field, for saving.
  template <class Fields>
  void each_field(Fields& fields) {
    fields(count_, last_, last_turn_, velocity_, turning_, has_last_);
    count_ = count_ <= k_max ? count_ : 0;  // may come from an invalid file
    for (std::size_t i = 0; i < count_; ++i) fields(slots_[i].id, slots_[i].memory);
  }
  /// Assigns loaded memories to the laws with the same ids.
  void bind_loaded(const LawSet& set) noexcept;

 private:
  struct Slot {
    std::uint32_t id = 0;
    ServoLaw::Step step = nullptr;
    alignas(std::max_align_t) std::array<std::byte, ServoLaw::k_memory> memory{};
    bool is_of(const ServoLaw& law) const noexcept { return id == law.id && step == law.step; }
  };
  void bind(const LawSet& set) noexcept;

  static constexpr std::size_t k_max = LawSet::k_max;
  std::array<Slot, k_max> slots_;
  std::size_t count_ = 0;
  glm::dvec3 last_{0.0}, velocity_{0.0}, turning_{0.0};
  glm::dquat last_turn_{1, 0, 0, 0};
  bool has_last_ = false;
};

}  // namespace trephine::haptics
