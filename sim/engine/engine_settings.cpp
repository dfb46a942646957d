// Engine: settings of hands, which are switches, poses of models, effects and tools.
#include <algorithm>
#include <cmath>

#include "haptics/force/effects.h"
#include "sim/engine/engine.h"
#include "sim/engine/scene_description.h"
#include "sim/engine/tool_geometry.h"

namespace trephine::sim {

namespace {

/// Returns the key of a command in PersistentState::latest_commands.
std::string key_of(const Command& command, std::int64_t number) {
  const std::string digits = std::to_string(number);
  return std::string(command.request.name()) + '/' + std::to_string(command.hand) + '/' +
         std::string(digits.size() < 10 ? 10 - digits.size() : 0, '0') + digits;
}

bool has_mover(const haptics::TouchScene& scene, std::int64_t mover) noexcept {
  return std::any_of(scene.items.begin(), scene.items.end(), [mover](const haptics::TouchItem& item) {
    return item.is_mesh() && item.mover == mover;
  });
}

/// Returns the laws with this one in place of that with its id; without a law that one is removed.
Result<std::shared_ptr<const haptics::LawSet>> replace_law(const haptics::LawSet* current, std::uint32_t id,
                                                           std::optional<haptics::ServoLaw> law) {
  std::vector<haptics::ServoLaw> list;
  if (current)
    for (const haptics::ServoLaw& one : current->laws())
      if (one.id != id) list.push_back(one);
  if (law) list.push_back(std::move(*law));
  // Sorted: forces are summed in this order, whatever the order of commands.
  std::sort(list.begin(), list.end(),
            [](const haptics::ServoLaw& a, const haptics::ServoLaw& b) { return a.id < b.id; });
  auto laws = std::make_shared<haptics::LawSet>();
  for (haptics::ServoLaw& one : list)
    if (Status error = laws->add(std::move(one))) return *error;
  return std::shared_ptr<const haptics::LawSet>(laws->laws().empty() ? nullptr : std::move(laws));
}

Result<std::shared_ptr<const haptics::LawSet>> laws_with_effect(const haptics::ServoHand& hand,
                                                                const SetEffect& request) {
  std::optional<haptics::ServoLaw> law;
  if (!request.words.empty()) {
    auto effect = haptics::parse_effect(request.words);
    if (!effect) return effect.error();
    auto output = haptics::law_of(effect.value(), request.effect.value);
    if (!output) return output.error();
    law = std::move(output).value();
    law->words = request.words;
  }
  return replace_law(hand.laws.get(), request.effect.value, std::move(law));
}

/// Least id of the effects of an instrument; no named effect has such an id.
constexpr std::uint32_t k_instruments_effect = 0xffffffff - (HandForces::k_max - 1);

HandForces forces_of(const Instrument& instrument) {
  return instrument.type && instrument.type->forces
             ? instrument.type->forces(instrument.parameters.data(), instrument.state.data())
             : HandForces();
}

/// Returns the hand's laws with those of an instrument.
Result<std::shared_ptr<const haptics::LawSet>> laws_with_forces(const haptics::ServoHand& hand,
                                                                const HandForces& forces) {
  std::shared_ptr<const haptics::LawSet> laws = hand.laws;
  for (std::size_t i = 0; i < HandForces::k_max; ++i) {
    const std::uint32_t id = k_instruments_effect + static_cast<std::uint32_t>(i);
    std::optional<haptics::ServoLaw> law;
    if (const auto& effect = forces.effects[i]) {
      auto output = haptics::law_of(*effect, id);
      if (!output) return output.error();
      law = std::move(output).value();
      law->words = haptics::words_of(*effect);
    }
    auto next = replace_law(laws.get(), id, std::move(law));
    if (!next) return next.error();
    laws = std::move(next).value();
  }
  return laws;
}

/// Checks that a hand with this instrument can touch with such a tool.
Status check_geometry(const haptics::TouchScene& scene, const Instrument& instrument,
                      const ToolGeometry& geometry) {
  auto tool = geometry.tool();
  if (!tool) return tool.error();
  const double radius = tool.value()->radius();
  if (Status error = check_tool_radius(*scene.base, radius)) return error;
  for (const haptics::TouchItem& shape : haptics::base_shapes(scene))
    if (radius > 0 && haptics::blocks(shape.sides, haptics::Side::back))
      return Error{.what = "contact from inside needs a tool without a radius",
                   .where = haptics::name_of(shape),
                   .found = "its back is touchable",
                   .expected = "shapes touched from the front",
                   .remedy = "use a point"};
  if (instrument.type == nullptr || instrument.type->check == nullptr) return std::nullopt;
  haptics::TouchScene changed = scene;
  changed.tool = std::move(tool).value();
  return instrument.type->check(instrument.parameters.data(), changed);
}

}  // namespace

Status Engine::check_setting(const Command& command) const {
  const haptics::ServoHand& hand = hands_[command.hand];
  const haptics::TouchScene& anatomy = *tools_[command.hand].scene;
  if (const auto* item = command.request.as<SwitchItem>()) {
    if (item->item < haptics::item_count(anatomy)) return std::nullopt;
    return Error{.what = "unknown item",
                 .where = "switch-item",
                 .found = std::to_string(item->item),
                 .expected = "0 to " + std::to_string(haptics::item_count(anatomy) - 1)};
  }
  if (const auto* place = command.request.as<PlaceModel>()) {
    if (std::none_of(tools_.begin(), tools_.end(),
                     [&](const HandTool& one) { return has_mover(*one.scene, place->mover); }))
      return Error{.what = "unknown moving model",
                   .where = "place-model",
                   .found = std::to_string(place->mover),
                   .expected = "the mover of a model"};
    return check_rotation(place->rotation, "place-model rotation");
  }
  if (const auto* depths = command.request.as<AdoptDepths>()) return check_depths(*depths, command.hand);
  if (const auto* picture = command.request.as<AdoptPicture>()) return check_picture(*picture, command.hand);
  if (const auto* effect = command.request.as<SetEffect>();
      effect && effect->effect.value >= k_instruments_effect)
    return Error{.what = "this effect belongs to the instrument",
                 .where = "set-effect",
                 .found = std::to_string(k_instruments_effect),
                 .expected = "a smaller number"};
  if (const auto* effect = command.request.as<SetEffect>())
    if (const auto laws = laws_with_effect(hand, *effect); !laws) return laws.error();
  if (const auto* geometry = command.request.as<ToolGeometry>())
    return check_geometry(anatomy, now_.settings.hands[command.hand], *geometry);
  if (const auto* take = command.request.as<TakeInstrument>()) return check_taking(*take, command.hand);
  return std::nullopt;
}

Status Engine::check_effect_of(const Instrument& instrument, std::size_t hand) const {
  const auto laws = laws_with_forces(hands_[hand], forces_of(instrument));
  return laws ? Status() : laws.error();
}

Result<Instrument> Engine::named_instrument(const TakeInstrument& request) const {
  HandSpec spec;
  spec.instrument = request.instrument, spec.parameters = request.parameters;
  auto instrument = sim::instrument_of(spec, catalogue_);
  if (instrument && instrument.value().type == nullptr)
    return Error{.what = "no instrument selected",
                 .where = "take-instrument instrument",
                 .expected = "the name of an instrument",
                 .remedy = "list them with trephine modules"};
  return instrument;
}

/// Returns what the hand touches with while it has this instrument: what the instrument needs, else what it
/// touched with at the start.
ToolGeometry Engine::geometry_of(const Instrument& instrument, std::size_t hand) const {
  const ToolNeeds needs = instrument.type && instrument.type->needs
                              ? instrument.type->needs(instrument.parameters.data(), *scene().base)
                              : ToolNeeds();
  return ToolGeometry::of(needs.tool ? *needs.tool : *initial_tools_[hand]);
}

Status Engine::check_taking(const TakeInstrument& request, std::size_t hand) const {
  const auto instrument = named_instrument(request);
  if (!instrument) return instrument.error();
  if (Status error =
          check_geometry(*tools_[hand].scene, instrument.value(), geometry_of(instrument.value(), hand)))
    return error;
  return check_effect_of(instrument.value(), hand);
}

/// Puts an instrument into a hand.
void Engine::give(Instrument instrument, std::size_t hand, Outcome& outcome) {
  now_.settings.hands[hand] = std::move(instrument);
  if (Change change = Change::removal; use_forces_of_instrument(hand, change))
    publish(change), outcome.is_changed = true;
  work_[hand].is_fresh = true;
  work_[hand].body.reset();
}

/// Applies the forces of the hand's instrument if they changed. Returns true in that case.
bool Engine::use_forces_of_instrument(std::size_t hand, Change& change) {
  HandForces forces = forces_of(now_.settings.hands[hand]);
  if (forces == forces_[hand]) return false;
  // Invalid forces are an error of the instrument; the old ones stay.
  auto laws = laws_with_forces(hands_[hand], forces);
  if (!laws) return false;
  // An item that blocks again may enclose the tool.
  const haptics::ShapeSet& next = forces.let_through;
  if ((next | forces_[hand].let_through) != next) change = Change::addition;
  hands_[hand].laws = std::move(laws).value();
  hands_[hand].let_through = next;
  forces_[hand] = std::move(forces);
  return true;
}

/// Applies a setting to its hand, or to all hands. Returns false for other commands. `number`: of the item,
/// mover or law.
bool Engine::set(const Command& command, std::int64_t& number, Change& change, Status& error) {
  haptics::ServoHand& hand = hands_[command.hand];
  if (const auto* item = command.request.as<SwitchItem>()) {
    hand.set_touchable(static_cast<int>(number = item->item), item->is_touchable);
    // An item that becomes touchable may enclose the tool.
    if (item->is_touchable) change = Change::addition;
  } else if (const auto* place = command.request.as<PlaceModel>()) {
    number = place->mover;
    const std::vector<double>& q = place->rotation;
    for (haptics::ServoHand& one : hands_)
      if (has_mover(*one.scene, number))
        one.set_placement(static_cast<int>(number), {place->position, {q[0], q[1], q[2], q[3]}});
  } else if (const auto* depths = command.request.as<AdoptDepths>()) {
    number = depths->item;
    if (!use_depths(*depths, command.hand))
      error = Error{.what = "the parameters of the depth images are invalid",
                    .where = "adopt-depths",
                    .found = std::to_string(number)};
  } else if (const auto* picture = command.request.as<AdoptPicture>()) {
    number = picture->item;
    use_picture(*picture, command.hand);
  } else if (const auto* effect = command.request.as<SetEffect>()) {
    number = effect->effect.value;
    auto laws = laws_with_effect(hand, *effect);
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
  Change change = Change::removal;
  Status error;  // excluded by check()
  if (!set(command, number, change, error)) return false;
  Command latest = command;
  if (latest.request.as<PlaceModel>()) latest.hand = 0;  // for all hands
  now_.settings.latest_commands.insert_or_assign(key_of(latest, number), latest);
  publish(change);
  return true;
}

/// Replaces the hand's tool, which is an addition: matter may reach where the old tool was free, and its
/// instrument if the job brings one. Returns false, and keeps the old tool, if it does not fit the
/// instrument.
bool Engine::adopt_geometry(const PendingJob& job, const JobResult& result, Outcome& outcome) {
  const auto& geometry = static_cast<const PreparedTool&>(result);
  const auto* take = job.parameters->as<TakeInstrument>();
  Instrument instrument = take ? named_instrument(*take).value() : now_.settings.hands[job.hand];
  const ToolGeometry needed = take ? geometry_of(instrument, job.hand) : *job.parameters->as<ToolGeometry>();
  const haptics::TouchScene& current_scene = *tools_[job.hand].scene;
  Status failed = geometry.failed;
  // The hand may have another instrument, or other balls, by now.
  if (!failed) failed = check_geometry(current_scene, instrument, needed);
  if (!failed && take) failed = check_effect_of(instrument, static_cast<std::size_t>(job.hand));
  if (failed) {
    pending_events_.push_back(
        {now_.next_tick, job.hand, glm::dvec3(0), JobDiscarded{job.id, failed->message()}});
    return false;
  }
  if (take) give(std::move(instrument), job.hand, outcome);
  HandTool& tool = tools_[job.hand];
  tool = {geometry.scene, geometry.method, tool.change_count + 1, tool.initial_method};
  use_bodies(job.hand, Bodies::others);
  use_fields();
  if (TouchFields* fields = fields_of(job.hand)) {
    // Its fields are valid if no cut was undone since.
    const bool is_cut_since = job.input->edits != now_.edits;
    TouchFields::Kept kept{{}, ever_cut_};
    if (addition_count_ == job.addition_count)
      kept = {geometry.offsets, is_cut_since ? ever_cut_ : k_no_voxels};
    fields->go_back(kept, current(), serial() + 1);
  }
  const Command latest{needed, job.hand};
  now_.settings.latest_commands.insert_or_assign(key_of(latest, 0), latest);
  publish(Change::addition);
  return true;
}

}  // namespace trephine::sim
