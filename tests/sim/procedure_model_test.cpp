// Compares procedures with an independent interpreter, for random procedures, commands and ticks.
#include "tests/sim/procedure_model.h"

namespace trephine::sim {
namespace {

template <class T, std::size_t N>
const T& any(std::mt19937& random, const T (&all)[N]) {
  return all[random() % N];
}

/// Returns a valid procedure at random.
volume::SurgicalProcedure random_procedure(std::mt19937& random) {
  static const char* const instruments[] = {"burr", "burr kinematic=no", "burr kinematic=no diameter=3", "*"};
  static const char* const commands[] = {"toy-mark",   "toy-carve",   "toy-flood", "toy-resize",
                                         "set-effect", "switch-item", "*",         "toy-mark"};
  static const char* const causes[] = {"",           "request",           "toy-mark", "toy-marked",
                                       "toy-carve",  "toy-marked",        "note",     "burr",
                                       "set-effect", "remove-instrument", "request",  "job-discarded"};
  static const char* const entries[] = {"note text=entered", "toy-mark at=1,2,3", "toy-resize radius=1"};
  const auto condition = [&]() -> volume::StepCondition {
    switch (random() % 8) {
      case 0:
        return {"removed_mm3", 0.5 * static_cast<double>(random() % 4), {}};
      case 1:
        return {"marks", static_cast<double>(random() % 3), static_cast<double>(3 + random() % 6)};
      case 2:
        return {"events toy-marked", static_cast<double>(1 + random() % 2), {}};
      case 3:
        return {"visits s1", {}, static_cast<double>(random() % 4)};
      case 4:
        return {"changes", static_cast<double>(random() % 6), {}};
      case 5:
        return {"step_seconds", 0.002 * static_cast<double>(random() % 3), {}};
      case 6:
        return {"found", -1, {}};
      default:
        return {"events step-refused", {}, static_cast<double>(random() % 3)};
    }
  };
  for (;;) {
    volume::SurgicalProcedure procedure;
    procedure.name = "random";
    if (random() % 3 == 0) procedure.commands = {any(random, commands)};
    if (random() % 3 == 0) procedure.instruments = {any(random, instruments)};
    const std::size_t steps = 3 + random() % 3;
    for (std::size_t s = 0; s < steps; ++s) {
      volume::ProcedureStep& step = procedure.steps.emplace_back();
      step.name = "s" + std::to_string(s);
      for (std::size_t i = random() % 3; i > 0; --i) step.commands.push_back(any(random, commands));
      if (random() % 2 == 0) step.instruments.push_back(any(random, instruments));
      if (random() % 3 == 0) step.on_entry.push_back(any(random, entries));
      for (std::size_t i = 1 + random() % 4; i > 0; --i) {
        volume::StepTransition& transition = step.transitions.emplace_back();
        transition.to = "s" + std::to_string(random() % steps);
        transition.on = any(random, causes);
        for (std::size_t c = transition.on.empty() ? 1 + random() % 2 : random() % 2; c > 0; --c)
          transition.conditions.push_back(condition());
      }
    }
    procedure.steps.push_back({"end", "", "", "", {}, {}, {}, true, {}});
    procedure.steps[steps - 1].transitions.push_back({"end", "request", {{"marks", 9.0, {}}}});
    if (!volume::check(procedure)) return procedure;
  }
}

/// Runs random commands and ticks on an engine and on the interpreter, and compares them after each.
class Comparison {
 public:
  Comparison(const ProcedureBench& bench, std::uint32_t seed, PlantedFault fault)
      : random_(seed),
        engine_(bench.planned_engine(k_hands)),
        model_(engine_.state().plan->procedure, k_hands, fault),
        cores_(k_hands, haptics::ServoCore({}, 1e-3)) {
    for (std::size_t h = 0; h < k_hands; ++h) cores_[h] = haptics::ServoCore({}, 1e-3, h);
  }

  /// Returns the first difference; empty if the two agree.
  std::string run(int count) {
    issue(engine_.take_initial_commands());
    for (int i = 0; i < count && difference_.empty(); ++i) {
      if (random_() % 3 == 0)
        for (int t = 1 + static_cast<int>(random_() % 4); t > 0 && difference_.empty(); --t) tick();
      else
        apply(random_one());
    }
    return difference_;
  }
  int entered = 0, refused = 0;

 private:
  static constexpr std::size_t k_hands = 2;

  std::vector<std::string> module_events(std::size_t first) const {
    std::vector<std::string> names;
    const Chronicle& chronicle = engine_.state().chronicle;
    for (std::size_t i = first; i < chronicle.size(); ++i)
      if (const Value& value = chronicle[i].value; !value.as<StepEntered>() && !value.as<StepRefused>())
        names.emplace_back(value.name());
    return names;
  }
  void differ(const std::string& text) {
    if (difference_.empty()) difference_ = text;
  }
  void compare(const std::string& what, std::size_t first) {
    const ProcedurePosition& position = engine_.state().undoable.procedure;
    const Position& expected = model_.now();
    const std::vector<std::string> events = steps_in(engine_.state().chronicle, first);
    for (const std::string& one : events) (one.starts_with("entered") ? entered : refused) += 1;
    if (events != model_.take_emitted()) differ("events after " + what);
    if (position.step != expected.step) differ("step after " + what);
    if (position.entered_tick != expected.entered_tick) differ("time after " + what);
    if (position.first_event != expected.first_event) differ("first event after " + what);
    if (position.visits != expected.visits) differ("visits after " + what);
  }
  void issue(const std::vector<Command>& commands) {
    // The depth is limited, since a cycle of steps may issue commands without end.
    if (++depth_ < 8)
      for (const Command& command : commands) apply(command);
    --depth_;
  }

  /// Returns the instrument that a command gives, with all its parameters; empty if it gives no instrument.
  std::string given(const Command& command) const {
    if (const auto* burr = command.request.as<drilling::Burr>()) return "burr " + Value(*burr).words();
    const auto* take = command.request.as<TakeInstrument>();
    if (take == nullptr) return "";
    Value burr{drilling::Burr()};
    EXPECT_FALSE(burr.set(take->parameters));
    return "burr " + burr.words();
  }

  void apply(const Command& command) {
    if (!difference_.empty()) return;
    const std::string name(command.request.name()), gives = given(command);
    const Facts before = facts_of(engine_);
    const std::size_t first = engine_.state().chronicle.size();
    // The toy module refuses the eleventh mark, which the procedure does not record.
    const bool has_ten = command.request.as<ToyMark>() && before.marks >= 10;
    const bool is_accepted = !has_ten && model_.accepts(command, gives, before);
    const bool was_allowed = !engine_.reason_to_refuse(command);
    std::string taken;
    int hand = 0;
    if (const auto* adopt = command.request.as<AdoptJob>())
      for (const PendingJob& job : engine_.jobs())
        if (job.id == adopt->job && job.parameters->as<TakeInstrument>())
          taken = given({*job.parameters, job.hand}), hand = job.hand;
    const bool can_hold = model_.allows_instrument(model_.now().step, taken);
    const Outcome outcome = engine_.apply(command);
    if (was_allowed == outcome.refused.has_value()) differ("reason to refuse " + name);
    if (outcome.refused.has_value() == is_accepted)
      differ((is_accepted ? "refused " : "allowed ") + name + " " + command.request.words());
    if (outcome.is_refusal_recorded != (!is_accepted && !has_ten)) differ("record of refused " + name);
    if (!is_accepted) {
      const auto* go = command.request.as<GoToStep>();
      if (!has_ten) model_.refuse(go ? go->step : command.request.as<TakeInstrument>() ? "burr" : name);
    } else {
      if (!taken.empty() && can_hold) model_.give(hand, taken);
      model_.command(command, gives, module_events(first), before, facts_of(engine_));
    }
    compare(name, first);
    std::vector<std::string> issued;
    for (const Command& next : outcome.next_commands)
      issued.push_back(std::string(next.request.name()) + " " + next.request.words());
    if (issued != normalized(model_.take_issued())) differ("issued commands after " + name);
    issue(outcome.next_commands);
  }
  /// Returns commands in the notation of Value::words(), with all their fields.
  static std::vector<std::string> normalized(const std::vector<std::string>& all) {
    std::vector<std::string> result;
    for (const std::string& one : all) {
      const std::size_t space = one.find(' ');
      const Command command = toys().command(one.substr(0, space), one.substr(space + 1)).value();
      result.push_back(std::string(command.request.name()) + " " + command.request.words());
    }
    return result;
  }

  void tick() {
    const double x = 0.2 * static_cast<double>(random_() % 20) - 2;
    const bool is_pressed = random_() % 3 != 0;
    for (std::size_t h = 0; h < k_hands; ++h) {
      haptics::ServoInput input;
      input.pose = haptics::rounded_to_grid(
          {{x + 3 * static_cast<double>(h), 0, is_pressed ? 1.5 : 4}, {1, 0, 0, 0}, is_pressed && h == 0});
      const haptics::ServoRecord record = cores_[h].step(*engine_.servo_scene(), input);
      const Facts before = facts_of(engine_);
      const std::size_t first = engine_.state().chronicle.size();
      const Outcome outcome = engine_.apply(record);
      model_.tick(h, record.tick + 1, record.pose.is_pressed(), module_events(first), before,
                  facts_of(engine_));
      compare("tick", first);
      if (outcome.next_commands.size() != model_.take_issued().size()) differ("issued commands after tick");
      issue(outcome.next_commands);
    }
  }

  Command random_one() {
    const auto hand = static_cast<std::uint8_t>(random_() % k_hands);
    static const char* const burrs[] = {"diameter=3 removal_rate=60", "diameter=2",
                                        "diameter=3 kinematic=yes"};
    const std::vector<PendingJob>& jobs = engine_.jobs();
    switch (random_() % 16) {
      case 0:
      case 1:
        return Undo{};
      case 2:
        return Redo{};
      case 3:
      case 4:
        return ToyMark{random_position(random_)};
      case 5:
        return ToyCarve{random_position(random_)};
      case 6:
        return ToyResize{1};
      case 7:
        return ToyFlood{random_position(random_)};
      case 8:
      case 9:
        if (jobs.empty()) return Command(TakeInstrument{"burr", any(random_, burrs)}, hand);
        return AdoptJob{jobs[random_() % jobs.size()].id};
      case 10:
        return Command(RemoveInstrument{}, hand);
      case 11: {
        Value burr{drilling::Burr()};
        EXPECT_FALSE(burr.set(any(random_, burrs)));
        return {burr, hand};
      }
      case 12:
        return random_() % 2 == 0 ? Command(SetEffect{{1}, ""}) : Command(SwitchItem{0, true});
      case 13:
        if (branches_ < 8) return BeginBranch{"b" + std::to_string(branches_++)};
        return Note{"a remark"};
      case 14:
        for (const Branch& other : engine_.other_branches())
          if (random_() % 2 == 0) return SwitchBranch{other.name};
        return Note{"a remark"};
      default:
        return GoToStep{"s" + std::to_string(random_() % 3)};
    }
  }

  std::mt19937 random_;
  Engine engine_;
  Model model_;
  std::vector<haptics::ServoCore> cores_;
  std::string difference_;
  int branches_ = 0, depth_ = 0;
};

TEST(Procedure, FollowsItsDescriptionForRandomCommandsAndTicks) {
  int entered = 0, refused = 0;
  ProcedureBench bench;
  for (std::uint32_t seed = 1; seed <= 40; ++seed) {
    std::mt19937 random(seed);
    auto plan = std::make_shared<volume::SurgicalPlan>();
    plan->procedure = random_procedure(random);
    bench.plan = plan;
    Comparison run(bench, seed, PlantedFault::none);
    EXPECT_EQ(run.run(120), "") << "seed " << seed;
    entered += run.entered, refused += run.refused;
  }
  EXPECT_GT(entered, 200);
  EXPECT_GT(refused, 200);
}

TEST(Procedure, EveryPlantedFaultIsDetected) {
  ProcedureBench bench;
  for (const PlantedFault fault :
       {PlantedFault::strict_limit, PlantedFault::last_transition, PlantedFault::blind_to_hands,
        PlantedFault::old_events, PlantedFault::kept_visits, PlantedFault::lax_star}) {
    std::string found;
    for (std::uint32_t seed = 1; seed <= 60 && found.empty(); ++seed) {
      std::mt19937 random(seed);
      auto plan = std::make_shared<volume::SurgicalPlan>();
      plan->procedure = random_procedure(random);
      bench.plan = plan;
      found = Comparison(bench, seed, fault).run(120);
    }
    EXPECT_NE(found, "") << static_cast<int>(fault);
  }
}

}  // namespace
}  // namespace trephine::sim
