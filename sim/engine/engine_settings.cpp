// Engine: settings of hands (touchable items, poses of models, effects and tools).
#include <algorithm>
#include <array>
#include <cmath>

#include "haptics/force/effects.h"
#include "sim/engine/core_commands.h"
#include "sim/engine/scene_description.h"
#include "sim/engine/step_rules.h"
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

/// Returns the current laws, with `law` in place of the law with this id. If `law` is empty, removes the law
/// with this id.
Result<std::shared_ptr<const haptics::LawSet>> replace_law(const haptics::LawSet* current, std::uint32_t id,
                                                           std::optional<haptics::ServoLaw> law) {
  std::vector<haptics::ServoLaw> list;
  if (current)
    for (const haptics::ServoLaw& one : current->laws())
      if (one.id != id) list.push_back(one);
  if (law) list.push_back(std::move(*law));
  // Sorts by id: forces are summed in this order, which must not depend on the order of commands.
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

/// Least id of the effects of an instrument. The command set-effect refuses this id and larger ones.
constexpr std::uint32_t k_first_instrument_effect = 0xffffffff - (HandForces::k_max - 1);

HandForces forces_of(const Instrument& instrument) {
  return instrument.type && instrument.type->forces
             ? instrument.type->forces(instrument.parameters.data(), instrument.state.data())
             : HandForces();
}

/// Returns the hand's laws, with the forces of an instrument as laws.
Result<std::shared_ptr<const haptics::LawSet>> laws_with_forces(const haptics::ServoHand& hand,
                                                                const HandForces& forces) {
  std::shared_ptr<const haptics::LawSet> laws = hand.laws;
  for (std::size_t i = 0; i < HandForces::k_max; ++i) {
    const std::uint32_t id = k_first_instrument_effect + static_cast<std::uint32_t>(i);
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

/// Checks that a hand with this instrument can touch the scene with this tool.
Status check_geometry(const haptics::TouchScene& scene, const Instrument& instrument,
                      const Result<haptics::SharedTool>& tool) {
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
  changed.tool = tool.value();
  return instrument.type->check(instrument.parameters.data(), changed);
}

}  // namespace

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

/// Returns the contact geometry of the hand with this instrument: the geometry that the instrument needs, or
/// else the hand's initial geometry. A model that the instrument cannot use as its tool is replaced by a
/// point.
haptics::SharedTool Engine::geometry_of(const Instrument& instrument, std::size_t hand) const {
  const ToolNeeds needs = instrument.type && instrument.type->needs
                              ? instrument.type->needs(instrument.parameters.data(), *scene().base)
                              : ToolNeeds();
  if (needs.tool) return needs.tool;
  const haptics::SharedTool& initial = initial_tools_[hand];
  if (!initial->mesh() || !instrument.type || !instrument.type->check) return initial;
  haptics::TouchScene with_model = *tools_[hand].scene;
  with_model.tool = initial;
  if (!instrument.type->check(instrument.parameters.data(), with_model)) return initial;
  return std::make_shared<const haptics::ToolShape>();
}

std::function<void(const std::atomic<bool>&)> Engine::preparation_of(const TakeInstrument& request,
                                                                     std::size_t hand) const {
  const auto instrument = named_instrument(request);
  if (!instrument) return {};
  const double radius = geometry_of(instrument.value(), hand)->radius();
  if (radius == 0 || check_tool_radius(*scene().base, radius)) return {};
  return [scene = tools_[hand].scene, radius](const std::atomic<bool>& is_cancelled) {
    haptics::prepare_offsets(*scene, radius, is_cancelled);
  };
}

/// Puts an instrument into a hand.
void Engine::give(Instrument instrument, std::size_t hand, Outcome& outcome) {
  state_.settings.hands[hand] = std::move(instrument);
  if (Change change = Change::removal; use_forces_of_instrument(hand, change))
    publish(change), outcome.is_changed = true;
  work_[hand].is_fresh = true;
  work_[hand].instrument_ball.reset();
}

/// Applies the forces of the hand's instrument if they changed and are valid; returns true in that case. Sets
/// `change` to addition if an item blocks again.
bool Engine::use_forces_of_instrument(std::size_t hand, Change& change) {
  HandForces forces = forces_of(state_.settings.hands[hand]);
  if (forces == forces_[hand]) return false;
  // Invalid forces are an error of the instrument; the previous forces stay.
  auto laws = laws_with_forces(hands_[hand], forces);
  if (!laws) return false;
  // An item that blocks again may enclose the tool.
  const haptics::ShapeSet& next = forces.passable_items;
  if ((next | forces_[hand].passable_items) != next) change = Change::addition;
  hands_[hand].laws = std::move(laws).value();
  hands_[hand].passable_items = next;
  forces_[hand] = std::move(forces);
  return true;
}

/// Replaces the hand's tool. If the job is a TakeInstrument, also replaces the instrument. The change counts
/// as an addition of matter, since the new tool may reach into matter where the old tool was free. If the new
/// tool or instrument cannot be used, keeps the old ones, emits JobDiscarded and returns false.
bool Engine::adopt_geometry(const PendingJob& job, const JobResult& result, Outcome& outcome) {
  const auto& geometry = static_cast<const PreparedTool&>(result);
  const auto* take = job.parameters->as<TakeInstrument>();
  Instrument instrument = take ? named_instrument(*take).value() : state_.settings.hands[job.hand];
  const Result<haptics::SharedTool> needed = requested_geometry(job);
  const haptics::TouchScene& current_scene = *tools_[job.hand].scene;
  Status failed = geometry.failed;
  // The hand may have received another instrument or tool since the job began.
  if (!failed) failed = check_geometry(current_scene, instrument, needed);
  if (!failed && take) failed = check_effect_of(instrument, static_cast<std::size_t>(job.hand));
  // Another step may have begun since the job began.
  if (!failed && take && has_procedure()) failed = check_instrument(procedure(), step(), instrument);
  if (failed) {
    pending_events_.push_back(
        {state_.next_tick, job.hand, glm::dvec3(0), JobDiscarded{job.id, failed->message()}});
    return false;
  }
  if (take) give(std::move(instrument), job.hand, outcome);
  HandTool& tool = tools_[job.hand];
  tool = {geometry.scene, geometry.method, tool.change_count + 1, tool.initial_method};
  use_bodies(job.hand, Bodies::changed);
  use_fields();
  if (TouchFields* fields = fields_of(job.hand)) {
    // The job's fields can be used if no matter was added since the job began. They lack cuts made since
    // then.
    const bool is_cut_since = job.input->edits != state_.edits;
    TouchFields::Kept kept{{}, ever_cut_};
    if (addition_count_ == job.addition_count)
      kept = {geometry.offsets, is_cut_since ? ever_cut_ : k_no_voxels};
    fields->go_back(kept, version(), serial() + 1);
  }
  const Command latest(take ? ToolGeometry::of(*needed.value()) : *job.parameters->as<ToolGeometry>(),
                       job.hand);
  state_.settings.latest_commands.insert_or_assign(key_of(latest, 0), latest);
  publish(Change::addition);
  return true;
}

/// Keeps an applied setting for a later restoration, and publishes it.
void Engine::record_setting(const Command& command, const Setting& setting, Outcome& outcome) {
  state_.settings.latest_commands.insert_or_assign(key_of(command, setting.number), command);
  publish(setting.change);
  outcome.is_changed = true;
}

struct HandCommands {
  static void remove_instrument(Engine& engine, const RemoveInstrument&, std::uint8_t hand,
                                Outcome& outcome) {
    engine.state_.settings.hands[hand] = {};
    if (Engine::Change change = Engine::Change::removal; engine.use_forces_of_instrument(hand, change))
      engine.publish(change), outcome.is_changed = true;
    engine.work_[hand].is_pressed = false;
    engine.work_[hand].instrument_ball.reset();
    if (!engine.is_in_stroke()) engine.end_stroke();
  }

  static Status check_switch(const Engine& engine, const SwitchItem& request, std::uint8_t hand) {
    const int count = haptics::item_count(*engine.tools_[hand].scene);
    if (request.item < count) return std::nullopt;
    return Error{.what = "unknown item",
                 .where = "switch-item",
                 .found = std::to_string(request.item),
                 .expected = "0 to " + std::to_string(count - 1)};
  }
  static Engine::Setting set_switch(Engine& engine, const SwitchItem& request, std::uint8_t hand) {
    engine.hands_[hand].set_touchable(static_cast<int>(request.item), request.is_touchable);
    // An item that becomes touchable may enclose the tool.
    return {request.item, request.is_touchable ? Engine::Change::addition : Engine::Change::removal};
  }

  static Status check_model(const Engine& engine, const PlaceModel& request, std::uint8_t) {
    if (std::none_of(engine.tools_.begin(), engine.tools_.end(),
                     [&](const HandTool& tool) { return has_mover(*tool.scene, request.mover); }))
      return Error{.what = "unknown moving model",
                   .where = "place-model",
                   .found = std::to_string(request.mover),
                   .expected = "a mover that a model of the scene has"};
    return check_rotation(request.rotation, "place-model rotation");
  }
  static Engine::Setting set_model(Engine& engine, const PlaceModel& request, std::uint8_t) {
    const std::vector<double>& q = request.rotation;
    for (haptics::ServoHand& hand : engine.hands_)
      if (has_mover(*hand.scene, request.mover))
        hand.set_placement(static_cast<int>(request.mover), {request.position, {q[0], q[1], q[2], q[3]}});
    return {request.mover};
  }

  static Status check_effect(const Engine& engine, const SetEffect& request, std::uint8_t hand) {
    if (request.effect.value >= k_first_instrument_effect)
      return Error{.what = "this effect belongs to the instrument",
                   .where = "set-effect",
                   .found = "effect " + std::to_string(request.effect.value),
                   .expected = "an effect below " + std::to_string(k_first_instrument_effect)};
    const auto laws = laws_with_effect(engine.hands_[hand], request);
    return laws ? Status() : laws.error();
  }
  static Engine::Setting set_effect(Engine& engine, const SetEffect& request, std::uint8_t hand) {
    Engine::Setting setting{request.effect.value};
    auto laws = laws_with_effect(engine.hands_[hand], request);
    if (laws)
      engine.hands_[hand].laws = std::move(laws).value();
    else
      setting.error = laws.error();
    return setting;
  }

  static Status check_geometry(const Engine& engine, const ToolGeometry& request, std::uint8_t hand) {
    return sim::check_geometry(*engine.tools_[hand].scene, engine.state_.settings.hands[hand],
                               request.tool());
  }
  static Status check_taking(const Engine& engine, const TakeInstrument& request, std::uint8_t hand) {
    const auto instrument = engine.named_instrument(request);
    if (!instrument) return instrument.error();
    if (Status error = sim::check_geometry(*engine.tools_[hand].scene, instrument.value(),
                                           engine.geometry_of(instrument.value(), hand)))
      return error;
    if (Status error = engine.check_effect_of(instrument.value(), hand)) return error;
    // Guards of the instrument's own command also apply to take-instrument.
    return engine.check_guards({instrument.value().parameters, hand});
  }
  template <class T>
  static void begin_job(Engine& engine, const T& request, std::uint8_t hand, Outcome& outcome) {
    engine.begin_job({request, hand}, {}, outcome);
  }

  template <class T, auto k_set>
  static void apply_setting(Engine& engine, const T& request, std::uint8_t hand, Outcome& outcome) {
    // A setting of all hands is stored under the first hand.
    const std::uint8_t owner = std::is_same_v<T, PlaceModel> ? std::uint8_t{0} : hand;
    engine.record_setting({request, owner}, k_set(engine, request, hand), outcome);
  }
  template <class T, auto k_set, auto k_check>
  static CoreCommand setting() {
    CoreCommand row = core_command<T, &apply_setting<T, k_set>, k_check>({.step_rule = StepRule::named});
    row.restore = [](Engine& engine, const Command& command) {
      return k_set(engine, *command.request.as<T>(), command.hand).error;
    };
    return row;
  }
};

std::span<const CoreCommand> hand_commands() noexcept {
  using Group = HandCommands;
  static const std::array all{
      core_command<RemoveInstrument, &Group::remove_instrument>({.step_rule = StepRule::every_step}),
      Group::setting<SwitchItem, &Group::set_switch, &Group::check_switch>(),
      Group::setting<PlaceModel, &Group::set_model, &Group::check_model>(),
      Group::setting<SetEffect, &Group::set_effect, &Group::check_effect>(),
      core_command<ToolGeometry, &Group::begin_job<ToolGeometry>, &Group::check_geometry>(
          {.step_rule = StepRule::named}),
      core_command<TakeInstrument, &Group::begin_job<TakeInstrument>, &Group::check_taking>()};
  return all;
}

}  // namespace trephine::sim
