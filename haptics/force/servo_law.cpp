#include "haptics/force/servo_law.h"

#include <algorithm>

#include "haptics/force/limited.h"

namespace trephine::haptics {

using glm::dvec3;

namespace {
constexpr double k_velocity_seconds = 0.003;  // time constant of the velocity for dampers
}

Status LawSet::add(ServoLaw law) {
  if (laws_.size() == k_max)
    return Error{.what = "too many servo laws",
                 .where = "laws of a hand",
                 .found = std::to_string(laws_.size() + 1),
                 .expected = "at most " + std::to_string(k_max)};
  for (const ServoLaw& other : laws_)
    if (other.id == law.id)
      return Error{.what = "two laws have the same id",
                   .where = "laws of a hand",
                   .found = std::to_string(law.id),
                   .expected = "a unique id per law"};
  laws_.push_back(std::move(law));
  return std::nullopt;
}

/// Sorts the memories into the set's order. A law with a known id and step function keeps its memory; the
/// memory of a new law starts as zeros.
void LawMemory::bind(const LawSet& set) noexcept {
  const auto is_bound = [&] {
    if (set.laws().size() != count_) return false;
    for (std::size_t i = 0; i < count_; ++i)
      if (!slots_[i].is_of(set.laws()[i])) return false;
    return true;
  };
  if (is_bound()) return;
  const std::array<Slot, LawSet::k_max> previous = slots_;
  for (std::size_t i = 0; i < set.laws().size(); ++i) {
    const ServoLaw& law = set.laws()[i];
    slots_[i] = {law.id, law.step, {}};
    for (std::size_t k = 0; k < count_; ++k)
      if (previous[k].is_of(law)) slots_[i].memory = previous[k].memory;
  }
  count_ = set.laws().size();
}

void LawMemory::bind_loaded(const LawSet& set) noexcept {
  for (std::size_t i = 0; i < count_; ++i)
    for (const ServoLaw& law : set.laws())
      if (slots_[i].id == law.id) slots_[i].step = law.step;
}

LawForces LawMemory::step(const LawSet& set, LawInput input) noexcept {
  bind(set);
  if (has_last_) {
    const double share = std::min(1.0, input.dt / k_velocity_seconds);
    velocity_ += share * ((input.hip_world - last_) / input.dt - velocity_);
    turning_ += share * (turn_between(last_turn_, input.orientation) / input.dt - turning_);
  }
  last_ = input.hip_world;
  last_turn_ = input.orientation;
  has_last_ = true;
  input.velocity_world = velocity_;
  input.angular_velocity_world = turning_;
  LawForces sum;
  for (std::size_t i = 0; i < count_; ++i) {
    const ServoLaw& law = set.laws()[i];
    law.step(law.parameters.get(), slots_[i].memory.data(), input, sum);
  }
  // The power of active laws on a moving hand is limited.
  const double speed = glm::length(velocity_);
  if (speed > 0) sum.active_world = limited(sum.active_world, k_power / speed);
  return sum;
}

}  // namespace trephine::haptics
