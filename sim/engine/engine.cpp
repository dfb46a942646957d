#include "sim/engine/engine.h"

#include <algorithm>
#include <array>

#include "sim/api/core_command.h"
#include "sim/engine/tool_geometry.h"

namespace trephine::sim {

namespace {

std::shared_ptr<const Value> shared(Value value) {
  return value.is_empty() ? nullptr : std::make_shared<const Value>(std::move(value));
}

}  // namespace

Engine::Engine(std::vector<HandStart> hands, double dt, const Catalogue& catalogue,
               std::vector<std::shared_ptr<const Forbidden>> forbidden,
               std::shared_ptr<const volume::SurgicalPlan> plan)
    : catalogue_(catalogue),
      editor_(haptics::uncut_version(*hands.at(0).touch.scene), haptics::solids_of(*hands[0].touch.scene)),
      trails_(hands.size()),
      work_(hands.size()),
      forbidden_(std::move(forbidden)) {
  state_.dt = dt;
  state_.plan = std::move(plan);
  state_.watches.resize(hands.size() * forbidden_.size());
  for (std::size_t h = 0; h < hands.size(); ++h) {
    const std::shared_ptr<const haptics::TouchScene>& scene = hands[h].touch.scene;
    TREPHINE_ASSERT(h == 0 || scene->base == hands_[0].scene->base);
    tools_.push_back({scene, hands[h].touch.method, 0, hands[h].touch.method->name()});
    initial_tools_.push_back(scene->tool);
    depths_.emplace_back(*scene, state_.dt);
    hands_.push_back(std::move(hands[h].touch));
    state_.settings.hands.push_back(std::move(hands[h].instrument));
  }
  for (const Module* module : catalogue_.modules()) {
    state_.undoable.modules.push_back(shared(module->undoable()));
    state_.settings.modules.push_back(shared(module->settings()));
    state_.settings.results.push_back({shared(module->result())});
  }
  forces_.resize(hands_.size());
  for (std::size_t h = 0; h < hands_.size(); ++h) {
    Change change = Change::removal;
    use_forces_of_instrument(h, change);
  }
  state_.undoable.version = published_version_ = uncut_ = editor_.publish();
  use_fields();
  publish(Change::removal);
  if (state_.plan && !state_.plan->procedure.is_empty()) begin_procedure();
  branch_.history.push_back(make_entry(k_no_voxels));
}

Engine::Engine(const haptics::TouchScene& scene, const haptics::ProxyMethod& method, Instrument instrument,
               double dt, const Catalogue& catalogue, std::vector<std::shared_ptr<const Forbidden>> forbidden)
    : Engine({HandStart{haptics::ServoHand(haptics::borrowed(scene), haptics::borrowed(method),
                                           haptics::TouchState(nullptr)),
                        std::move(instrument)}},
             dt, catalogue, std::move(forbidden)) {}

Outcome Engine::apply(const haptics::ServoRecord& tick) {
  Outcome outcome;
  HandWork& hand = work_[tick.hand];
  are_initial_commands_due_ = false;
  const std::uint64_t previous_tick = state_.next_tick;
  state_.next_tick = std::max(state_.next_tick, tick.tick + 1);
  trails_[tick.hand].add(servo_hand(tick.hand), tick);
  record_faults(tick);
  Instrument& instrument = state_.settings.hands[tick.hand];
  if ((tick.raised & haptics::fault_not_finite) == 0) {
    hand.placement = haptics::placement_of(tick.pose);
    depths_[tick.hand].record_positions(tick.pose.position_world, tick.proxy_world);
  }
  const InstrumentInput input{tick, state_.dt, std::exchange(hand.is_fresh, false),
                              tool(tick.hand).scene->tool->radius()};
  bool was_pressed = false;
  if (instrument.type != nullptr) {
    Work work(editor_, pending_events_, tick.tick, tick.hand);
    instrument.type->step(instrument.parameters.data(), instrument.state.data(), input, work);
    const bool is_working =
        instrument.type->is_working &&
        instrument.type->is_working(instrument.parameters.data(), instrument.state.data());
    was_pressed = std::exchange(hand.is_pressed, tick.pose.is_pressed() || is_working);
    if (work.removed().bricks_changed > 0) {
      state_.undoable.version = published_version_ = editor_.publish();
      ++state_.edits;
      publish(Change::removal);
      record_cut(work.removed());
      outcome.is_changed = outcome.is_edit = true;
      outcome.box = work.removed().box;
    }
  }
  if (instrument.type != nullptr && instrument.type->forces != nullptr)
    if (Change change = Change::removal; use_forces_of_instrument(tick.hand, change))
      publish(change), outcome.is_changed = true;
  if (!forbidden_.empty()) watch_forbidden(input);
  if (!state_.undoable.bodies.empty()) end_motions(previous_tick, outcome);
  const bool is_stroke_over = was_pressed && !is_in_stroke();
  handle_events(
      outcome,
      {tick.tick, tick.hand, {}, is_stroke_over ? StepCause::When::always : StepCause::When::events});
  if (is_stroke_over) end_stroke();
  return outcome;
}

Outcome Engine::apply(const Command& command) {
  Outcome outcome;
  const CoreCommand* core = command.request.is_empty() ? nullptr : find_core_command(command.request.type());
  if (!command.request.as<Resume>()) are_initial_commands_due_ = false;
  outcome.refused = check(command, core);
  if (!outcome.refused && (outcome.refused = check_step(command, core))) record_refusal(command, outcome);
  if (outcome.refused) {
    if (core && core->discard) core->discard(*this, command);
    return outcome;
  }
  carry_out(command, core, outcome);
  const bool is_passed_to_modules = !core || core->is_passed_to_modules;
  if (is_passed_to_modules)
    for (std::size_t m = 0; m < catalogue_.modules().size(); ++m) {
      ModuleReaction reaction(state_of(m, state_.edits), pending_events_, state_.next_tick, command.hand);
      catalogue_.modules()[m]->react_to_command(command, state_, reaction);
      if (reaction.is_undoable_changed()) is_stroke_changed_ = outcome.is_edit = true;
    }
  StepCause cause{state_.next_tick, command.hand};
  if (is_passed_to_modules) cause.command = command.request.name(), cause.when = StepCause::When::always;
  if (core && !core->causes_transitions) cause.when = StepCause::When::never;
  handle_events(outcome, cause);
  return outcome;
}

Status Engine::reason_to_refuse(const Command& command) const {
  const CoreCommand* core = command.request.is_empty() ? nullptr : find_core_command(command.request.type());
  if (Status error = check(command, core)) return error;
  return check_step(command, core);
}

/// Checks a command before any change, apart from the rules of the procedure. `core`: the row of the command,
/// or null.
Status Engine::check(const Command& command, const CoreCommand* core) const {
  if (command.request.is_empty()) return Error{.what = "the command is empty", .expected = "a command"};
  const ValueType& type = command.request.type();
  if (Status error = command.request.check()) return error;
  if (command.hand >= hand_count())
    return Error{.what = "unknown hand",
                 .where = std::string(command.request.name()),
                 .found = std::to_string(command.hand + 1),
                 .expected = "1 to " + std::to_string(hand_count())};
  const JobType* job = nullptr;
  std::size_t module = 0;
  if (core) {
    if (Status error = core->check ? core->check(*this, command) : Status()) return error;
    if (!core->is_guarded) return std::nullopt;
  } else if (const InstrumentType* instrument = instrument_of(command)) {
    if (instrument->check)
      if (Status error = instrument->check(command.request.data(), *tools_[command.hand].scene)) return error;
    if (Status error = check_effect_of(Instrument(*instrument, command.request), command.hand)) return error;
  } else if (!contains(catalogue_.all(), type) || catalogue_.is_event(type)) {
    return Error{.what = "no module of this session knows the command",
                 .found = std::string(command.request.name()),
                 .expected = "a command of its modules",
                 .remedy = "load the module of the command, or choose another command"};
  } else if (find_job(type, job, module)) {
    if (Status error = check_job(*job, command)) return error;
  }
  return check_guards(command);
}

/// Returns the error of the first module that does not allow the command.
Status Engine::check_guards(const Command& command) const {
  for (const Module* module : catalogue_.modules())
    if (Status error = module->allows(command, state_)) return error;
  return std::nullopt;
}

void Engine::carry_out(const Command& command, const CoreCommand* core, Outcome& outcome) {
  const Value& request = command.request;
  if (core) {
    if (core->apply) core->apply(*this, command, outcome);
  } else if (const InstrumentType* instrument = instrument_of(command)) {
    Instrument next = state_.settings.hands[command.hand];
    if (next.type == instrument)
      next.parameters = request;
    else
      next = Instrument(*instrument, request);
    give(std::move(next), command.hand, outcome);
  } else {
    PendingJob job;
    if (find_job(request.type(), job.type, job.module)) return begin_job(command, std::move(job), outcome);
    for (std::size_t m = 0; m < catalogue_.modules().size(); ++m) {
      const Module& module = *catalogue_.modules()[m];
      if (!contains(module.commands(), request.type())) continue;
      ModuleWork work(Work(editor_, pending_events_, state_.next_tick, command.hand),
                      state_of(m, state_.edits));
      module.apply(command, work);
      return finish(work, outcome);
    }
  }
}

/// Returns the instrument whose parameters are the request: that of the hand, or an instrument of the
/// modules. Null for other commands.
const InstrumentType* Engine::instrument_of(const Command& command) const noexcept {
  const ValueType& type = command.request.type();
  if (const InstrumentType* held = state_.settings.hands[command.hand].type;
      held && held->parameters == &type)
    return held;
  const InstrumentType* known = catalogue_.find_instrument(command.request.name());
  return known && known->parameters == &type ? known : nullptr;
}

ModuleState Engine::state_of(std::size_t module, std::uint64_t edits) noexcept {
  return {state_.undoable.modules[module], state_.settings.modules[module], state_.settings.results[module],
          edits};
}

/// Publishes the work of a module, and marks undoable changes.
void Engine::finish(const ModuleWork& work, Outcome& outcome) {
  const bool is_cut = work.removed().bricks_changed > 0;
  const bool is_any_body_removed = remove_bodies(work.removed_bodies());
  if (!is_cut && !work.is_restored() && !work.is_undoable_changed() && !is_any_body_removed) return;
  if (is_cut || work.is_restored()) ++state_.edits;
  is_stroke_changed_ = outcome.is_edit = true;
  if (work.is_restored()) {
    editor_.reset(uncut_);
    state_.undoable.version = published_version_ = editor_.publish();
    if (!state_.undoable.bodies.empty()) {
      state_.undoable.bodies.clear();
      use_bodies(Bodies::changed);
    }
    for (TouchFields& fields : fields_) fields.go_back({}, version(), serial() + 1);
    publish(Change::addition);
    for (HandWork& hand : work_) hand.is_fresh = true;
    outcome.box = {glm::ivec3(0), scene().base->size - 1};
    stroke_box_ = outcome.box;
  } else if (is_cut) {
    state_.undoable.version = published_version_ = editor_.publish();
    publish(Change::removal);
    record_cut(work.removed());
    outcome.box = work.removed().box;
  } else if (is_any_body_removed) {
    publish(Change::removal);
  }
  outcome.is_changed = is_cut || work.is_restored() || is_any_body_removed;
}

void Engine::record_faults(const haptics::ServoRecord& tick) {
  std::uint32_t& reported = work_[tick.hand].noted_faults;
  const std::uint32_t latched = tick.faults & haptics::k_latched_faults, new_faults = latched & ~reported;
  const auto emit_fault = [&](std::uint32_t faults, bool is_cleared) {
    pending_events_.push_back(
        {tick.tick, tick.hand, tick.proxy_world, FaultEvent{haptics::fault_names(faults), is_cleared}});
  };
  if (new_faults != 0) emit_fault(new_faults, false);
  if (latched == 0 && reported != 0) emit_fault(reported, true);
  reported = latched;
}

void Engine::record_cut(const volume::RemovalReport& report) {
  for (TouchFields& fields : fields_) fields.record_cut(version(), serial(), report.box);
  is_stroke_changed_ = true;
  stroke_box_ = union_of(stroke_box_, report.box);
  ever_cut_ = union_of(ever_cut_, report.box);
}

bool Engine::is_in_stroke() const noexcept {
  return std::any_of(work_.begin(), work_.end(), [](const HandWork& hand) { return hand.is_pressed; });
}

void Engine::end_stroke() {
  for (HandWork& hand : work_) hand.is_pressed = false, hand.is_fresh = true;
  if (!is_stroke_changed_) return;
  editor_.end_stroke();
  add_entry(std::exchange(stroke_box_, k_no_voxels));
  is_stroke_changed_ = false;
}

/// Publishes the current scene of the hands with a new serial, for servos to adopt. After an addition of
/// matter each hand is given its escape path.
void Engine::publish(Change change) {
  std::shared_ptr<haptics::ServoScene> next = make_scene(servo_scene_ ? serial() + 1 : 1);
  if (change == Change::addition) {
    ++addition_count_;
    for (std::size_t h = 0; h < hands_.size(); ++h) {
      // Trails have no rotations: a tool with six degrees of freedom is released without a path.
      const bool has_trail = !tools_[h].scene->tool->is_six_dof();
      haptics::EscapePath path = has_trail ? trails_[h].escape_path(hands_[h]).value_or(haptics::EscapePath{})
                                           : haptics::EscapePath{};
      path.serial = next->serial;
      hands_[h].escape_path = std::make_shared<const haptics::EscapePath>(path);
    }
  }
  next->hands = hands_;
  next->has_held = has_held();
  servo_scene_ = std::move(next);
}

/// Updates the touch states of the hands. Returns a new scene to which publish() adds the hands.
std::shared_ptr<haptics::ServoScene> Engine::make_scene(std::uint64_t serial) {
  auto next = std::make_shared<haptics::ServoScene>();
  next->serial = serial;
  for (std::size_t h = 0; h < hands_.size(); ++h) {
    const TouchFields* fields = fields_of(h);
    hands_[h].state = haptics::TouchState(published_version_, fields ? fields->newest() : OffsetFields());
    hands_[h].state.depths = depths_[h].newest();
  }
  return next;
}

TouchFields* Engine::fields_of(std::size_t hand) noexcept {
  for (TouchFields& fields : fields_)
    if (fields.scene() == tools_[hand].scene) return &fields;
  return nullptr;
}

/// Keeps one TouchFields per scene with a round tool that a hand uses.
void Engine::use_fields() {
  std::erase_if(fields_, [this](const TouchFields& fields) {
    return std::none_of(tools_.begin(), tools_.end(),
                        [&](const HandTool& tool) { return tool.scene == fields.scene(); });
  });
  for (std::size_t h = 0; h < hands_.size(); ++h)
    if (tools_[h].scene->tool->radius() > 0 && fields_of(h) == nullptr) fields_.emplace_back(tools_[h].scene);
}

std::optional<haptics::EscapePath> Engine::escape_path(std::size_t hand) const {
  std::optional<haptics::EscapePath> path = trails_[hand].escape_path(servo_hand(hand));
  if (path) path->serial = serial();
  return path;
}

/// Handles the events of a tick or a command, which may cause a transition to another step.
void Engine::handle_events(Outcome& outcome, const StepCause& cause) {
  const std::size_t first_event = state_.chronicle.size();
  pass_events(outcome);
  if (has_procedure() && cause.when != StepCause::When::never &&
      (cause.when == StepCause::When::always || state_.chronicle.size() > first_event ||
       (is_stroke_changed_ && !is_in_stroke()))) {
    take_transition(cause, first_event, outcome);
    pass_events(outcome);
  }
  outcome.event_count = state_.chronicle.size() - first_event;
  if (is_stroke_changed_ && !is_in_stroke()) end_stroke();
}

/// Passes events to the modules, and adds them to the chronicle.
void Engine::pass_events(Outcome& outcome) {
  // Modules may add events, which this loop handles too.
  for (std::size_t i = 0; i < pending_events_.size(); ++i) {
    Event event = std::move(pending_events_[i]);
    for (std::size_t m = 0; m < catalogue_.modules().size(); ++m) {
      ModuleReaction reaction(state_of(m, state_.edits), pending_events_, event.tick, event.hand);
      catalogue_.modules()[m]->react(event, state_, reaction);
      if (reaction.is_undoable_changed()) is_stroke_changed_ = outcome.is_edit = true;
    }
    state_.chronicle.add(std::move(event));
  }
  pending_events_.clear();
}

// ---- snapshots and measures ----

void Engine::freeze() {
  if (state_.undoable.version->is_frozen()) return;
  state_.undoable.version = editor_.freeze();
}

std::shared_ptr<const OperationState> Engine::snapshot() {
  freeze();
  return std::make_shared<const OperationState>(state_);
}

double Engine::removed_mm3() const noexcept { return version()->mm3_of(version()->ledger().total()); }

std::vector<double> Engine::removed_mm3_by_label() const {
  std::vector<double> result;
  for (const std::int64_t units : version()->ledger().units_by_label)
    result.push_back(version()->mm3_of(units));
  return result;
}

Overlays Engine::overlays() const {
  Overlays result;
  for (const Body& body : state_.undoable.bodies) {
    Overlay& overlay = result.emplace_back();
    overlay.kind = Overlay::Kind::object;
    overlay.matter = body.matter, overlay.is_detached = !body.is_implant;
    overlay.name = (body.is_implant ? "implant " : "piece ") + std::to_string(body.id.value);
    overlay.surface = body.piece->tree;
    overlay.placement = placement_of(body);
    overlay.holder = body.holder;
    overlay.grip = body.grip;
  }
  for (const haptics::TouchItem* item : models()) {
    Overlay& overlay = result.emplace_back();
    overlay.kind = item->depth && item->depth->is_streamed() ? Overlay::Kind::scenery : Overlay::Kind::object;
    overlay.matter = item->matter;
    overlay.name = haptics::name_of(*item);
    overlay.surface = surface_of(*item);
    overlay.placement = placement_of(*item);
  }
  for (const Module* module : catalogue_.modules())
    for (Overlay& overlay : module->overlays(state_)) result.push_back(std::move(overlay));
  add_injuries(result);
  return result;
}

double Engine::clearance(std::size_t hand, std::size_t structure) const {
  const ForbiddenWatch& watched = watch(hand, structure);
  const std::optional<ToolBall>& body = work_[hand].instrument_ball;
  return body ? forbidden_[structure]->clearance(*body, watched.clearance) : watched.clearance;
}

std::vector<Measure> Engine::measures() const {
  std::vector<Measure> result{{"removed", removed_mm3(), "mm3"},
                              {"changes", static_cast<double>(stroke_count()), ""},
                              {"undos", static_cast<double>(state_.chronicle.undos), ""}};
  for (std::size_t s = 0; s < forbidden_.size(); ++s) {
    ForbiddenWatch worst;
    for (std::size_t h = 0; h < hand_count(); ++h)
      if (watch(h, s).nearest < worst.nearest) worst = watch(h, s);
    result.push_back({"nearest to " + forbidden_[s]->name(), worst.nearest, "mm"});
  }
  for (const Module* module : catalogue_.modules())
    for (Measure& measure : module->measures(state_)) result.push_back(std::move(measure));
  return result;
}

}  // namespace trephine::sim
