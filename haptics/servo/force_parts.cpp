#include "haptics/servo/force_parts.h"

#include <glm/geometric.hpp>
#include <utility>

namespace trephine::haptics {

using glm::dvec3;

namespace {

Wrench difference(const Wrench& a, const Wrench& b) {
  return {a.force_world - b.force_world, a.torque_world - b.torque_world};
}

/// Returns a copy of the scene in which a hand lacks one law.
ServoScene without_law(const ServoScene& scene, std::size_t hand, std::size_t law) {
  ServoScene result = scene;
  auto laws = std::make_shared<LawSet>();
  const std::vector<ServoLaw>& all = scene.hands[hand].laws->laws();
  for (std::size_t i = 0; i < all.size(); ++i)
    if (i != law) (void)laws->add(all[i]);  // a smaller set of valid laws is valid
  result.hands[hand].laws = std::move(laws);
  return result;
}

}  // namespace

double ForceParts::friction_ratio() const noexcept {
  if (!record.has_contact) return 0;
  const dvec3 spring = step.proxy_world - record.pose.position_world;
  const double along = glm::dot(spring, step.normal_world);
  return along > 0 ? glm::length(spring - along * step.normal_world) / along : 0;
}

ForceParts force_parts(const ServoCore& before, const ServoScene& scene, const ServoInput& input) {
  const DenormalsFlushed flushed;
  ForceParts result;
  const auto add = [&result](ForcePart::Kind kind, std::string name, const Wrench& wrench) {
    constexpr double k_rounding = 1e-9;  // N, N mm
    if (glm::length(wrench.force_world) + glm::length(wrench.torque_world) > k_rounding)
      result.parts.push_back({kind, std::move(name), wrench});
  };
  ServoCore core = before;
  result.record = core.step(scene, input);
  result.step = core.last_step();
  const ServoRecord& record = result.record;
  using Kind = ForcePart::Kind;
  const bool has_hand = before.hand_ < scene.hands.size();
  if (!has_hand || (record.raised & fault_not_finite) != 0) {  // neither contact nor effects were computed
    add(Kind::limits, "limits and fade", record.wrench());
    return result;
  }
  const ServoHand& hand = scene.hands[before.hand_];
  const Wrench smoothed = core.force_.smoothed();
  Wrench newest;  // force of the surface before smoothing
  if (record.has_contact) {
    result.stiffness = contact_stiffness(result.step, *hand.scene);
    result.material = material_of(*hand.scene, result.step.shape, result.step.side);
    Wrench spring(result.stiffness * (result.step.proxy_world - record.pose.position_world));
    if (hand.scene->tool->is_six_dof())
      spring.torque_world = hand.scene->tool->gyration_square() * result.stiffness * result.step.turn_world;
    const bool is_fresh = input.is_reset || input.is_restarted;
    const Wrench previous = is_fresh ? Wrench() : before.force_.smoothed();
    const double alpha = core.force_.alpha();
    newest.force_world = (smoothed.force_world - (1 - alpha) * previous.force_world) / alpha;
    newest.torque_world = (smoothed.torque_world - (1 - alpha) * previous.torque_world) / alpha;
    add(Kind::spring, "spring", spring);
    add(Kind::damping, "damping", difference(newest, spring));
  }
  add(Kind::smoothing, "smoothing", difference(smoothed, newest));
  // The passivity controller is switched off here, because it limits the sum of all forces. Without it, the
  // difference of two results is the part of one effect.
  const auto requested = [&](const ServoScene& one) {
    ServoCore copy = before;
    copy.is_passive_ = false;
    (void)copy.step(one, input);
    return copy.requested_;
  };
  const Wrench all = requested(scene);
  Wrench contact = all, effects;
  if (hand.laws) {
    const std::size_t count = hand.laws->laws().size();
    ServoScene without_laws = scene;
    without_laws.hands[before.hand_].laws = nullptr;
    contact = requested(without_laws);
    for (std::size_t i = 0; i < count; ++i) {
      const Wrench part = difference(all, requested(without_law(scene, before.hand_, i)));
      add(Kind::effect, hand.laws->laws()[i].words, part);
      effects.force_world += part.force_world, effects.torque_world += part.torque_world;
    }
  }
  add(Kind::transition, "transition", difference(contact, smoothed));
  add(Kind::power, "power limit of effects", difference(difference(all, contact), effects));
  add(Kind::energy, "passivity controller", difference(core.requested_, all));
  add(Kind::limits, "limits and fade", difference(record.wrench(), core.requested_));
  return result;
}

}  // namespace trephine::haptics
