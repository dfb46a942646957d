// Changes of a hand's scene midway: switches, places of models, effects, tools.
#include <algorithm>
#include <cmath>

#include "haptics/force/effects.h"
#include "sim/engine.h"
#include "sim/tool_geometry.h"

namespace trephine::sim {

using volume::Error;
using volume::Status;

namespace {

/// Under which OperationState keeps it.
std::string key_of(const Command& command, std::int64_t number) {
  const std::string digits = std::to_string(number);
  return std::string(command.what.name()) + '/' + std::to_string(command.hand) + '/' +
         std::string(digits.size() < 10 ? 10 - digits.size() : 0, '0') + digits;
}

bool has_mover(const haptics::TouchScene& scene, std::int64_t mover) noexcept {
  return std::any_of(scene.items.begin(), scene.items.end(), [mover](const haptics::TouchItem& item) {
    return item.is_mesh() && item.mover == mover;
  });
}

/// The hand's laws with this one in place of that of its id; without a law it ends.
volume::Result<std::shared_ptr<const haptics::LawSet>> with_law(const haptics::LawSet* before,
                                                                std::uint32_t id,
                                                                std::optional<haptics::ServoLaw> law) {
  std::vector<haptics::ServoLaw> all;
  if (before)
    for (const haptics::ServoLaw& one : before->laws())
      if (one.id != id) all.push_back(one);
  if (law) all.push_back(std::move(*law));
  // In one order, whatever the order of commands: forces are summed in it.
  std::sort(all.begin(), all.end(),
            [](const haptics::ServoLaw& a, const haptics::ServoLaw& b) { return a.id < b.id; });
  auto laws = std::make_shared<haptics::LawSet>();
  for (haptics::ServoLaw& one : all)
    if (Status error = laws->add(std::move(one))) return *error;
  return std::shared_ptr<const haptics::LawSet>(laws->laws().empty() ? nullptr : std::move(laws));
}

volume::Result<std::shared_ptr<const haptics::LawSet>> laws_after(const haptics::ServoHand& hand,
                                                                  const SetEffect& request) {
  std::optional<haptics::ServoLaw> law;
  if (!request.words.empty()) {
    auto effect = haptics::parse_effect(request.words);
    if (!effect) return effect.error();
    auto made = haptics::law_of(effect.value(), request.effect.value);
    if (!made) return made.error();
    law = std::move(made).value();
    law->words = request.words;
  }
  return with_law(hand.laws.get(), request.effect.value, std::move(law));
}

/// No named effect has it.
constexpr std::uint32_t k_instruments_effect = 0xffffffff;

/// The hand's laws with that which an instrument makes.
volume::Result<std::shared_ptr<const haptics::LawSet>> laws_with(const haptics::ServoHand& hand,
                                                                 const Instrument& held) {
  const std::string words =
      held.type && held.type->effect ? held.type->effect(held.parameters.data()) : std::string();
  return laws_after(hand, SetEffect{{k_instruments_effect}, words});
}

/// Can a hand that holds this feel with such a ball, or so many?
Status check_radius(const haptics::TouchScene& scene, const Instrument& held, double radius,
                    const std::vector<glm::dvec3>& balls) {
  if (Status error = haptics::check_tool_balls(radius, balls)) return error;
  if (Status error = check_tool_radius(*scene.base, radius)) return error;
  for (const haptics::TouchItem& shape : haptics::base_shapes(scene))
    if (radius > 0 && haptics::holds(shape.sides, haptics::Side::back))
      return Error{"a tool with a radius cannot be held from within", haptics::name_of(shape),
                   "its back is touchable", "shapes touched from the front", "use a point"};
  if (held.type == nullptr || held.type->check == nullptr) return std::nullopt;
  haptics::TouchScene with = scene;
  with.tool_radius = radius;
  with.tool_balls = balls;
  return held.type->check(held.parameters.data(), with);
}

}  // namespace

Status Engine::check_setting(const Command& command) const {
  const haptics::ServoHand& hand = hands_[command.hand];
  const haptics::TouchScene& anatomy = *tools_[command.hand].scene;
  if (const auto* item = command.what.as<SwitchItem>()) {
    if (item->item < haptics::item_count(anatomy)) return std::nullopt;
    return Error{"there is no such item", "switch-item", std::to_string(item->item),
                 "0 to " + std::to_string(haptics::item_count(anatomy) - 1), ""};
  }
  if (const auto* place = command.what.as<PlaceModel>()) {
    if (std::none_of(tools_.begin(), tools_.end(),
                     [&](const HandTool& one) { return has_mover(*one.scene, place->mover); }))
      return Error{"no model moves by this number", "place-model", std::to_string(place->mover),
                   "the mover of a model", ""};
    return check_rotation(place->rotation, "place-model rotation");
  }
  if (const auto* depths = command.what.as<AdoptDepths>()) return check_depths(*depths, command.hand);
  if (const auto* picture = command.what.as<AdoptPicture>()) return check_picture(*picture, command.hand);
  if (const auto* effect = command.what.as<SetEffect>();
      effect && effect->effect.value == k_instruments_effect)
    return Error{"this effect is the instrument's own", "set-effect", std::to_string(k_instruments_effect),
                 "a smaller number", ""};
  if (const auto* effect = command.what.as<SetEffect>())
    if (const auto laws = laws_after(hand, *effect); !laws) return laws.error();
  if (const auto* geometry = command.what.as<ToolGeometry>())
    return check_radius(anatomy, now_.settings.hands[command.hand], geometry->radius, geometry->balls);
  return std::nullopt;
}

Status Engine::check_effect_of(const Instrument& held, std::size_t hand) const {
  const auto laws = laws_with(hands_[hand], held);
  return laws ? Status() : laws.error();
}

/// True: it has another force in addition to surfaces than before.
bool Engine::use_effect_of_instrument(std::size_t hand) {
  const auto words = [](const std::shared_ptr<const haptics::LawSet>& laws) {
    return laws && laws->laws().back().id == k_instruments_effect ? laws->laws().back().words : std::string();
  };
  auto laws = laws_with(hands_[hand], now_.settings.hands[hand]);
  if (!laws || words(laws.value()) == words(hands_[hand].laws)) return false;
  hands_[hand].laws = std::move(laws).value();
  return true;
}

/// Into what its hand feels, or all of them. False: it is no setting of a hand. `number`: of the item, mover
/// or law.
bool Engine::set(const Command& command, std::int64_t& number, Change& change, Status& error) {
  haptics::ServoHand& hand = hands_[command.hand];
  if (const auto* item = command.what.as<SwitchItem>()) {
    hand.set_touchable(static_cast<int>(number = item->item), item->is_touchable);
    // An item that may hold again may be all around the tool.
    if (item->is_touchable) change = Change::growth;
  } else if (const auto* place = command.what.as<PlaceModel>()) {
    number = place->mover;
    const std::vector<double>& q = place->rotation;
    for (haptics::ServoHand& one : hands_)
      if (has_mover(*one.scene, number))
        one.set_placement(static_cast<int>(number), {place->position, {q[0], q[1], q[2], q[3]}});
  } else if (const auto* depths = command.what.as<AdoptDepths>()) {
    number = depths->item;
    if (!use_depths(*depths, command.hand))
      error = Error{"such depth images cannot be made", "adopt-depths", std::to_string(number), "", ""};
  } else if (const auto* picture = command.what.as<AdoptPicture>()) {
    number = picture->item;
    use_picture(*picture, command.hand);
  } else if (const auto* effect = command.what.as<SetEffect>()) {
    number = effect->effect.value;
    auto laws = laws_after(hand, *effect);
    if (laws)
      hand.laws = std::move(laws).value();
    else
      error = laws.error();
  } else {
    return false;
  }
  return true;
}

bool Engine::record_setting(const Command& command) {
  std::int64_t number = 0;
  Change change = Change::cut;
  Status error;  // which check() has looked for
  if (!set(command, number, change, error)) return false;
  Command told = command;
  if (told.what.as<PlaceModel>()) told.hand = 0;  // for all of them
  now_.settings.told.insert_or_assign(key_of(told, number), told);
  publish(change);
  return true;
}

/// The hand has another tool: matter may reach where the old one was free, so it is growth. False: what it
/// holds by now does not fit, and the old one stays.
bool Engine::adopt_geometry(const PendingJob& job, const JobResult& result) {
  const auto& made = static_cast<const MadeGeometry&>(result);
  Status failed = made.failed;
  // The hand may hold something else by now.
  if (!failed)
    failed = check_radius(*tools_[job.hand].scene, now_.settings.hands[job.hand], made.scene->tool_radius,
                          made.scene->tool_balls);
  if (failed) {
    news_.push_back({now_.next_tick, job.hand, glm::dvec3(0), JobDiscarded{job.id, failed->message()}});
    return false;
  }
  HandTool& tool = tools_[job.hand];
  tool = {made.scene, made.method, tool.number + 1, tool.own};
  use_bodies(job.hand, Bodies::others);
  use_fields();
  if (TouchFields* fields = fields_of(job.hand)) {
    // Its knowledge of cuts holds if none of them was undone since.
    const bool is_cut_since = job.edits != edits_;
    TouchFields::Kept kept{{}, ever_cut_};
    if (growths_ == job.growths) kept = {made.offsets, is_cut_since ? ever_cut_ : k_no_voxels};
    fields->go_back(kept, current(), serial() + 1);
  }
  const Command told{*job.parameters, job.hand};
  now_.settings.told.insert_or_assign(key_of(told, 0), told);
  publish(Change::growth);
  return true;
}

}  // namespace trephine::sim
