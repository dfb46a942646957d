// Procedures: equal states in all drivers, recorded refusals, undo history, lines of a header, checks of
// names.
#include <thread>

#include "sim/drivers/live_session.h"
#include "sim/engine/measurement.h"
#include "tests/sim/opens_anywhere.h"
#include "tests/sim/procedure_bench.h"

namespace trephine::sim {
namespace {

haptics::Pose in_air() { return {{0, 0, 8}, {1, 0, 0, 0}, false}; }

/// Operates through all steps of sample_procedure(), with refused commands, undo and branches.
void operate(Lockstep& run) {
  const auto rest = [&](int ticks) {
    for (int i = 0; i < ticks; ++i) run.step(in_air());
  };
  const auto is_done = [&](Command command) { return !run.apply_and_finish(command).refused; };
  rest(20);
  EXPECT_EQ(step_of(run.engine()), "mark");
  EXPECT_FALSE(is_done(TakeInstrument{"burr", k_taken_burr}));  // refused in the first step
  EXPECT_FALSE(is_done(ToyCarve{}));
  EXPECT_TRUE(is_done(ToyMark{dvec3(1)}));
  rest(20);
  EXPECT_TRUE(is_done(ToyMark{dvec3(2)}));
  EXPECT_EQ(step_of(run.engine()), "drill");
  EXPECT_FALSE(is_done(GoToStep{"inspect"}));  // nothing is removed yet
  EXPECT_FALSE(is_done(TakeInstrument{"burr", "diameter=3 kinematic=yes"}));
  EXPECT_TRUE(is_done(TakeInstrument{"burr", k_taken_burr}));
  const haptics::PosePath path = drilling_path(10);
  for (int i = 0; i < 1500; ++i) {
    run.step(path.at(1e-3 * i));
    if (i % 400 == 399) run.undo();
    if (i == 900) run.redo();
  }
  rest(50);
  EXPECT_GT(run.engine().removed_mm3(), 0.5);
  EXPECT_FALSE(is_done(GoToStep{"inspect"}));  // the hand holds the burr
  EXPECT_TRUE(is_done(RemoveInstrument{}));
  EXPECT_TRUE(is_done(GoToStep{"inspect"}));
  EXPECT_TRUE(is_done(BeginBranch{"second"}));
  EXPECT_TRUE(is_done(ToyCarve{dvec3(0)}));
  EXPECT_EQ(step_of(run.engine()), "drill");
  rest(500);
  EXPECT_TRUE(is_done(SwitchBranch{"main"}));
  EXPECT_EQ(step_of(run.engine()), "inspect");
  EXPECT_TRUE(is_done(ToyMark{dvec3(3)}));
  EXPECT_TRUE(is_done(ToyMark{dvec3(4)}));
  EXPECT_EQ(step_of(run.engine()), "close");
  EXPECT_FALSE(is_done(ToyMark{dvec3(5)}));
  rest(500);
}

TEST(Procedure, IsEqualInLockstepReplayAndAfterSeeking) {
  const Folder folder;
  const std::string path = folder.file("steps.session");
  const ProcedureBench bench;
  std::uint64_t states[2];
  std::vector<std::string> steps;
  for (const bool is_recorded : {false, true}) {
    auto writer = is_recorded ? bench.planned_writer(path, with_checkpoint_work(300)) : nullptr;
    Lockstep run(bench.planned_engine(), {}, 1000, writer.get());
    operate(run);
    states[is_recorded] = run.engine().state().hash();
    steps = steps_in(run.engine().state().chronicle);
    if (writer) {
      ASSERT_FALSE(writer->finish(run.engine()));
    }
  }
  EXPECT_EQ(states[0], states[1]);
  const std::vector<std::string> expected{
      "refused burr in mark",  "refused toy-carve in mark", "entered drill",   "refused inspect in drill",
      "refused burr in drill", "refused inspect in drill",  "entered inspect", "entered drill",
      "entered close",         "refused toy-mark in close"};
  EXPECT_EQ(steps, expected);
  const Verdict verdict = replay(path, bench.scene.base, toys());
  expect_same(verdict);
  EXPECT_EQ(verdict.state, states[1]);
  expect_opens_anywhere(path, toys(), bench.scene.base, 4);

  // Commands on entry are in the log, once per visit.
  auto opened = SessionReader::open(path, toys());
  ASSERT_TRUE(opened.is_ok()) << opened.error().message();
  std::map<std::string, int> notes;
  int refused = 0;
  for (LogItem item; opened.value().next(item).value();) {
    if (const auto* command = std::get_if<CommandItem>(&item))
      if (const auto* note = command->command.request.as<Note>()) ++notes[note->text];
    if (const auto* event = std::get_if<EventItem>(&item))
      refused += event->event.value.as<StepRefused>() != nullptr;
  }
  EXPECT_EQ(notes["begun"], 1);
  EXPECT_EQ(notes["drill now"], 2);
  EXPECT_EQ(refused, 6);
}

TEST(Procedure, CostsNothingWhereThePlanHasNone) {
  const ToyBench bench;
  const ProcedureBench planned{volume::SurgicalProcedure()};
  Engine without = bench.engine(), with = planned.planned_engine();
  EXPECT_EQ(with.state().undoable.procedure, ProcedurePosition());
  EXPECT_TRUE(with.take_initial_commands().empty());
  const Outcome outcome = without.apply(GoToStep{"drill"});
  ASSERT_TRUE(outcome.refused);
  EXPECT_EQ(outcome.refused->what, "the operation has no procedure");
  EXPECT_FALSE(outcome.is_refusal_recorded);
  EXPECT_EQ(without.state().chronicle.size(), 0u);
  // The header of its session lists no types of procedures. With a procedure the header lists all types.
  SessionHeader header = describe_scene(bench.scene, *bench.method, {}, burr_spec());
  describe(toys(), header);
  for (const NamedVersion& type : header.types)
    EXPECT_TRUE(type.name != "go-to-step" && !type.name.starts_with("step-")) << type.name;
  header = planned.header();
  header.plan.procedure = sample_procedure();
  describe(toys(), header);
  EXPECT_EQ(types_of(header, toys()), toys().all());
}

TEST(LiveSession, FollowsAProcedureAndReplays) {
  const Folder folder;
  const std::string path = folder.file("live.session");
  const ProcedureBench bench;
  auto writer = bench.planned_writer(path);
  haptics::VirtualDevice device(drilling_path(60), {});
  std::array<haptics::Device*, 1> devices{&device};
  LiveSession live(devices, bench.planned_engine(), {}, writer.get());
  ASSERT_FALSE(live.start());
  const auto apply = [&](Command command) {
    live.apply(std::move(command));
    live.snapshot().wait();
    const LiveState state = live.fetch_state();
    while (live.fetch_state().pending_jobs > 0) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    return state;
  };
  EXPECT_EQ(live.fetch_state().step, 0);
  const auto reasons = live.reasons_to_refuse({ToyMark{dvec3(1)}, ToyCarve{}}).get();
  ASSERT_EQ(reasons.size(), 2u);
  EXPECT_FALSE(reasons[0]);
  EXPECT_TRUE(reasons[1]);
  EXPECT_TRUE(apply(ToyCarve{}).refused);
  apply(ToyMark{dvec3(1)});
  EXPECT_EQ(apply(ToyMark{dvec3(2)}).step, 1);
  EXPECT_LE(live.fetch_state().step_tick, live.snapshot().get()->next_tick);
  apply(TakeInstrument{"burr", k_taken_burr});
  for (int i = 0; i < 5000 && live.fetch_state().removed_mm3 < 1; ++i)
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  apply(RemoveInstrument{});
  EXPECT_EQ(apply(GoToStep{"inspect"}).step, 2);
  live.stop();
  const std::uint64_t state = live.engine().state().hash();
  ASSERT_FALSE(writer->finish(live.engine()));
  const Verdict verdict = replay(path, bench.scene.base, toys());
  expect_same(verdict);
  EXPECT_EQ(verdict.state, state);
}

TEST(Procedure, IsUndoneWithTheStrokeThatEndedAStep) {
  const ProcedureBench bench;
  Lockstep run(bench.planned_engine(), {}, 1000);
  const auto position = [&] { return run.engine().state().undoable.procedure; };
  run.step(in_air());
  run.apply(ToyMark{dvec3(1)});
  const ProcedurePosition before = position();
  run.apply(ToyMark{dvec3(2)});
  EXPECT_EQ(step_of(run.engine()), "drill");
  ASSERT_FALSE(run.apply_and_finish(TakeInstrument{"burr", k_taken_burr}).refused);
  // The first step allows no burr.
  const Outcome refused = run.undo();
  ASSERT_TRUE(refused.refused);
  EXPECT_TRUE(refused.is_refusal_recorded);
  EXPECT_NE(refused.refused->message().find("remove-instrument"), std::string::npos);
  EXPECT_EQ(step_of(run.engine()), "drill");
  run.apply(RemoveInstrument{});
  ASSERT_FALSE(run.undo().refused);
  ProcedurePosition after = position();
  EXPECT_EQ(after.first_event,
            run.engine().state().chronicle.size());  // earlier events do not count any more
  after.first_event = before.first_event;
  EXPECT_EQ(after, before);
  EXPECT_EQ(Toy::toy_undoable(run.engine().state()).marks, 1);
  ASSERT_FALSE(run.redo().refused);
  EXPECT_EQ(step_of(run.engine()), "drill");
  EXPECT_EQ(position().visits, (std::vector<std::uint32_t>{1, 1, 0, 0}));
}

TEST(Procedure, GivesNoInstrumentThatAnotherStepForbids) {
  volume::SurgicalProcedure procedure = sample_procedure();
  procedure.steps[0].instruments = {"burr"};
  const ProcedureBench bench(procedure);
  Engine engine = bench.planned_engine();
  EXPECT_EQ(engine.take_initial_commands().size(), 1u);
  EXPECT_TRUE(engine.take_initial_commands().empty());
  const Outcome begun = engine.apply(TakeInstrument{"burr", "diameter=3 kinematic=yes"});
  ASSERT_FALSE(begun.refused);
  engine.apply(ToyMark{dvec3(1)});
  engine.apply(ToyMark{dvec3(2)});
  EXPECT_EQ(step_of(engine), "drill");
  engine.apply(engine.run_job(begun.job));
  EXPECT_EQ(engine.state().settings.hands[0].type, nullptr);
  const Chronicle& chronicle = engine.state().chronicle;
  const auto* discarded = chronicle[chronicle.size() - 1].value.as<JobDiscarded>();
  ASSERT_NE(discarded, nullptr);
  EXPECT_NE(discarded->reason.find("kinematic=yes"), std::string::npos) << discarded->reason;
}

TEST(Procedure, StatesReasonsAndRemedies) {
  const ProcedureBench bench;
  Engine engine = bench.planned_engine();
  const auto reason = [&](const Command& command) {
    const Status error = engine.reason_to_refuse(command);
    return error ? error->message() : std::string();
  };
  EXPECT_EQ(reason(Note{"a remark"}), "");
  const std::string carve = reason(ToyCarve{});
  for (const char* part :
       {"step mark", "toy-carve", "toy-mark, toy-resize", "drill", "after toy-marked", "marks at least 2"})
    EXPECT_NE(carve.find(part), std::string::npos) << part << "\n" << carve;
  engine.apply(ToyMark{dvec3(1)});
  engine.apply(ToyMark{dvec3(2)});
  engine.apply(engine.run_job(engine.apply(TakeInstrument{"burr", "diameter=3"}).job));
  const std::string request = reason(GoToStep{"inspect"});
  for (const char* part : {"removed_mm3 0", "removed_mm3 at least 0.5", "hand 1", "burr"})
    EXPECT_NE(request.find(part), std::string::npos) << part << "\n" << request;
  EXPECT_NE(reason(GoToStep{"mark"}).find("inspect"), std::string::npos);
  EXPECT_NE(reason(GoToStep{"nowhere"}).find("mark, drill, inspect, close"), std::string::npos);
  EXPECT_NE(reason(drilling::Burr{3, 60, 40, true}).find("kinematic=yes"), std::string::npos);
}

TEST(Procedure, ACycleOfIssuedCommandsEnds) {
  volume::SurgicalProcedure procedure = sample_procedure();
  procedure.steps.resize(2);
  for (std::size_t s = 0; s < 2; ++s) {
    procedure.steps[s].on_entry = {"note text=again"};
    procedure.steps[s].transitions = {{procedure.steps[1 - s].name, "note", {}}};
  }
  const ProcedureBench bench(procedure);
  Lockstep run(bench.planned_engine(), {}, 1000);
  const auto steps = [&] { return steps_in(run.engine().state().chronicle); };
  ASSERT_EQ(steps().size(), Engine::k_max_steps_per_tick + 1);
  const Chronicle& events = run.engine().state().chronicle;
  const auto* refusal = events[events.size() - 1].value.as<StepRefused>();
  ASSERT_NE(refusal, nullptr);
  EXPECT_NE(refusal->reason.find("form a cycle"), std::string::npos) << refusal->reason;
  run.step(in_air());
  EXPECT_EQ(steps().size(), Engine::k_max_steps_per_tick + 1) << "the cycle ended";
}

TEST(Measurements, CountEventsOfOneHandOrAll) {
  const ProcedureBench bench;
  const auto bone = Forbidden::build(bench.scene.base, bench.scene.items[0].field.shape()).value();
  std::vector<HandStart> hands = bench.hands(2);
  for (HandStart& hand : hands) hand.instrument = drilling::burr(k_burr);
  Engine engine(hands, 1e-3, toys(), {bone}, bench.plan);
  std::vector<haptics::ServoCore> cores;
  for (std::size_t h = 0; h < 2; ++h) cores.emplace_back(haptics::ForceOptions(), 1e-3, h);
  for (int i = 0; i < 10; ++i)
    for (std::size_t h = 0; h < 2; ++h) {
      haptics::ServoInput input;
      input.pose = haptics::rounded_to_grid({{0, 0, 9 - 2 * static_cast<double>(h)}, {1, 0, 0, 0}, false});
      engine.apply(cores[h].step(*engine.servo_scene(), input));
    }
  const auto value = [&](const std::string& name, const MeasurementScope& scope) {
    return Measurements(engine, scope).value_of(name);
  };
  const std::string nearest = "nearest_mm " + bone->name();
  const double high = value(nearest, {.hand = 0}).value(), low = value(nearest, {.hand = 1}).value();
  EXPECT_NEAR(high - low, 2, 0.5);
  EXPECT_EQ(value(nearest, {}), low);
  EXPECT_FALSE(value("nearest_mm nothing", {}));
  engine.apply(Command(ToyMark{dvec3(1)}, 1));
  EXPECT_EQ(value("events toy-marked", {.hand = 0}), 0);
  EXPECT_EQ(value("events toy-marked", {.hand = 1}), 1);
  EXPECT_EQ(value("events toy-marked", {}), 1);
  EXPECT_EQ(value("events toy-marked", {.first_event = engine.state().chronicle.size()}), 0);
  EXPECT_EQ(value("visits mark", {}), 1);
  EXPECT_EQ(value("visits drill", {}), 0);
  EXPECT_NEAR(value("step_seconds", {}).value(), 0.01, 1e-9);
  EXPECT_EQ(value("changes", {}), 1);  // the mark
  EXPECT_EQ(value("found", {.accepts_stale = false}), 0);
  // A later cut makes the result stale: unknown in conditions, and still known in scripts.
  std::vector<HandStart> cutting = bench.hands(1);
  Engine other(cutting, 1e-3, toys());
  other.apply(ToyFlood{dvec3(0, 0, 90)});
  other.apply(other.run_job(other.jobs()[0].id));
  EXPECT_TRUE(Measurements(other, {.accepts_stale = false}).value_of("found"));
  other.apply(ToyCarve{dvec3(0)});
  EXPECT_GT(other.removed_mm3(), 0);
  EXPECT_FALSE(Measurements(other, {.accepts_stale = false}).value_of("found"));
  EXPECT_TRUE(Measurements(other, {}).value_of("found"));
  EXPECT_FALSE(Measurements(other, {}).value_of("step_seconds"));
  // Conditions with unknown values are not met.
  EXPECT_FALSE(Measurements(other, {.accepts_stale = false}).meets({"found", -1e300, {}}));
  EXPECT_FALSE(Measurements(other, {}).meets({"nothing", {}, 1.0}));
  EXPECT_TRUE(Measurements(other, {}).meets({"changes", 2.0, 2.0}));
}

/// Returns a log of two marks, the second of which begins a step, two refused commands, and ticks.
std::vector<LogItem> sample_log(const ProcedureBench& bench) {
  Engine engine = bench.planned_engine();
  haptics::ServoCore core({}, 1e-3);
  std::vector<LogItem> items;
  const auto add_events = [&](const Outcome& outcome) {
    const Chronicle& chronicle = engine.state().chronicle;
    for (std::size_t i = chronicle.size() - outcome.event_count; i < chronicle.size(); ++i)
      items.push_back(EventItem{chronicle[i]});
  };
  const auto apply = [&](const Command& command) {
    const Outcome outcome = engine.apply(command);
    items.push_back(CommandItem{command});
    add_events(outcome);
  };
  const auto tick = [&] {
    haptics::ServoInput input;
    input.pose = haptics::rounded_to_grid(in_air());
    const haptics::ServoRecord record = core.step(*engine.servo_scene(), input);
    add_events(engine.apply(record));
    items.push_back(TickItem{record, output_check(record)});
  };
  tick();
  apply(ToyMark{dvec3(1)});
  apply(ToyCarve{});
  tick();
  apply(GoToStep{"inspect"});
  apply(ToyMark{dvec3(2)});
  tick();
  return items;
}

TEST(Procedure, ForgedLogsAreDetected) {
  const Folder folder;
  const std::string path = folder.file("forged.session");
  const ProcedureBench bench;
  SessionHeader header = bench.header();
  describe(toys(), header);
  const std::vector<LogItem> log = sample_log(bench);
  const auto is_refusal = [](const LogItem& item) {
    const auto* event = std::get_if<EventItem>(&item);
    return event && event->event.value.as<StepRefused>();
  };
  const auto is_carve = [](const LogItem& item) {
    const auto* command = std::get_if<CommandItem>(&item);
    return command && command->command.request.as<ToyCarve>();
  };
  using Items = std::vector<LogItem>;
  const auto at = [](Items& items, auto&& is_it) { return std::find_if(items.begin(), items.end(), is_it); };
  const std::pair<const char*, std::function<void(Items&)>> forgeries[] = {
      {"no forgery", [](Items&) {}},
      {"no event of the refusal", [&](Items& items) { items.erase(at(items, is_refusal)); }},
      {"no refused command", [&](Items& items) { items.erase(at(items, is_carve)); }},
      {"another reason",
       [&](Items& items) {
         auto& event = std::get<EventItem>(*at(items, is_refusal)).event;
         event.value = StepRefused{"mark", "toy-carve", "no reason"};
       }},
      {"an allowed command", [&](Items& items) { *at(items, is_carve) = CommandItem{Note{"a remark"}}; }},
      {"another refused command", [&](Items& items) { *at(items, is_carve) = CommandItem{ToyFlood{}}; }},
      {"a refused command twice",
       [&](Items& items) { items.insert(at(items, is_carve), *at(items, is_carve)); }},
      {"no mark", [&](Items& items) { items.erase(items.begin() + 1); }}};
  for (const auto& [name, forge] : forgeries) {
    SCOPED_TRACE(name);
    Items items = log;
    forge(items);
    ItemEncoder encoder(types_of(header, toys()));
    for (const LogItem& item : items) {
      if (const auto* tick = std::get_if<TickItem>(&item)) encoder.add(tick->record);
      if (const auto* command = std::get_if<CommandItem>(&item)) encoder.add(*command);
      if (const auto* event = std::get_if<EventItem>(&item)) encoder.add(*event);
    }
    write_session(path, header, encoder.fetch_bytes());
    const Verdict verdict = replay(path, bench.scene.base, toys());
    EXPECT_EQ(verdict.error, "");
    EXPECT_EQ(verdict.mismatch.has_value(), std::string(name) != "no forgery");
  }
}

TEST(Procedure, IsPartOfAHeader) {
  const ProcedureBench bench;
  SessionHeader header = bench.header();
  header.plan.score = {{"L4 left: breach", 0, 4, 10}, {"canal", 120.5, 60, 1}};
  header.plan.procedure.score = {{"canal", 100, 60, 1}, {"time", 60, 300, 2}};
  const std::string text = encode(header);
  const auto back = decode_header(text);
  ASSERT_TRUE(back.is_ok()) << back.error().message();
  EXPECT_EQ(back.value().plan, header.plan);
  EXPECT_EQ(encode(back.value()), text);
  for (const char* line :
       {"procedure=twice", "step=no way to it", "step=mark", "step_end=2", "step_title=a \\ letter",
        "step_hint=\\", "transition=nowhere\ntransition_on=note", "transition_on=note", "condition=marks",
        "condition_minimum=1", "transition_colour=red", "score=canal width", "score_full_at=x",
        "score_weight=-1", "score_colour=red", "procedure_score=time", "procedure_score_weight=-1",
        "step_colour=red", "procedure_colour=red"})
    EXPECT_FALSE(decode_header(text + line + "\n").is_ok()) << line;
  // A line is refused if the line of its object does not precede it. The error quotes the refused line.
  SessionHeader empty = bench.header();
  empty.plan = {};
  for (const char* line : {"step_title=a", "transition=mark", "condition_minimum=1", "score_full_at=1",
                           "procedure_score_full_at=1"}) {
    const auto broken = decode_header(encode(empty) + line + "\n");
    ASSERT_FALSE(broken.is_ok()) << line;
    EXPECT_NE(broken.error().where.find("line "), std::string::npos) << line;
    EXPECT_EQ(broken.error().found, line);
  }
}

TEST(Procedure, BeginsWithInstrumentsOfTheFirstStep) {
  const ProcedureBench bench;
  SceneDescription spec = bench.header();
  ASSERT_TRUE(build_scene(spec, bench.scene.base, toys()).is_ok());
  spec.hands[0].instrument = "burr";
  spec.hands[0].parameters = "diameter=3";
  const auto refused = build_scene(spec, bench.scene.base, toys());
  ASSERT_FALSE(refused.is_ok());
  EXPECT_EQ(refused.error().where, "hand 1, step mark");
  EXPECT_NE(refused.error().remedy.find("empty hand"), std::string::npos);
  spec.plan.procedure.instruments = {"burr kinematic=no"};
  EXPECT_TRUE(build_scene(spec, bench.scene.base, toys()).is_ok());
  spec.hands[0].parameters = "diameter=3 kinematic=yes";
  EXPECT_FALSE(build_scene(spec, bench.scene.base, toys()).is_ok());
}

TEST(Procedure, NamesAreChecked) {
  using Procedure = volume::SurgicalProcedure;
  ASSERT_FALSE(check_procedure(sample_procedure(), toys()));
  const std::pair<const char*, std::function<void(Procedure&)>> faults[] = {
      {"scalpel", [](Procedure& p) { p.steps[1].instruments = {"scalpel"}; }},
      {"colour", [](Procedure& p) { p.instruments = {"burr colour=red"}; }},
      {"no name", [](Procedure& p) { p.instruments = {" "}; }},
      {"toy-paint", [](Procedure& p) { p.steps[0].commands.push_back("toy-paint"); }},
      {"toy-marked", [](Procedure& p) { p.commands = {"toy-marked"}; }},
      {"list it under the instruments", [](Procedure& p) { p.commands = {"burr"}; }},
      {"resume", [](Procedure& p) { p.commands = {"resume"}; }},
      {"toy-painted", [](Procedure& p) { p.steps[0].transitions[0].on = "toy-painted"; }},
      {"undo", [](Procedure& p) { p.steps[0].transitions[0].on = "undo"; }},
      {"step-entered", [](Procedure& p) { p.steps[0].transitions[0].on = "step-entered"; }},
      {"toy-carve", [](Procedure& p) { p.steps[0].on_entry = {"toy-carve at=1,2,3"}; }},
      {"toy-resize radius", [](Procedure& p) { p.steps[0].on_entry = {"toy-resize radius=9"}; }},
      {"go-to-step", [](Procedure& p) { p.steps[0].on_entry = {"go-to-step step=drill"}; }},
      {"burr", [](Procedure& p) { p.steps[0].on_entry = {"take-instrument instrument=burr"}; }},
      {"events toy-painted",
       [](Procedure& p) { p.steps[0].transitions[0].conditions[0].measurement = "events toy-painted"; }},
      {"visits nowhere",
       [](Procedure& p) { p.steps[0].transitions[0].conditions[0].measurement = "visits nowhere"; }},
      {"nowhere", [](Procedure& p) { p.steps[0].transitions[0].to = "nowhere"; }}};
  for (const auto& [part, change] : faults) {
    Procedure procedure = sample_procedure();
    change(procedure);
    const Status error = check_procedure(procedure, toys());
    ASSERT_TRUE(error) << part;
    EXPECT_NE(error->message().find(part), std::string::npos) << error->message();
    EXPECT_NE(
        error->where.find(procedure.commands != sample_procedure().commands || !procedure.instruments.empty()
                              ? "procedure opening"
                              : "step "),
        std::string::npos)
        << error->message();
  }
  const ProcedureBench bench;
  const Engine engine = bench.planned_engine();
  EXPECT_FALSE(check_step_measurements(sample_procedure(), engine, toys()));
  Procedure procedure = sample_procedure();
  std::string& name = procedure.steps[0].transitions[0].conditions[0].measurement;
  name = "nearest_mm dura";  // this operation has no such structure
  const Status error = check_step_measurements(procedure, engine, toys());
  ASSERT_TRUE(error);
  EXPECT_EQ(error->where, "step mark, transition to drill");
  name = "L4: canal";  // a module may add this measure later
  EXPECT_FALSE(check_step_measurements(procedure, engine, toys()));
}

}  // namespace
}  // namespace trephine::sim
