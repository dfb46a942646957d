// ProcedureBench: empty hands on the small bone, the toy module, and a plan with a procedure.
#pragma once

#include "sim/engine/procedure_check.h"
#include "tests/sim/toy_bench.h"

namespace trephine::sim {

inline constexpr const char* k_taken_burr = "diameter=3 removal_rate=60 feed_limit=40";

/// Returns a procedure with the steps mark, drill, inspect and close.
inline volume::SurgicalProcedure sample_procedure() {
  volume::SurgicalProcedure procedure;
  procedure.name = "opening";
  procedure.title = "An opening";
  procedure.commands = {"toy-resize"};
  procedure.steps.resize(4);
  volume::ProcedureStep& mark = procedure.steps[0];
  mark.name = "mark";
  mark.title = "Mark the bone";
  mark.hint = "Two marks,\nthen go on.\\";
  mark.commands = {"toy-mark"};
  mark.on_entry = {"note text=begun"};
  mark.transitions = {{"drill", "toy-marked", {{"marks", 2.0, {}}}}};
  volume::ProcedureStep& drill = procedure.steps[1];
  drill.name = "drill";
  drill.note = "Without resistance, stop.";
  drill.instruments = {"burr kinematic=no"};
  drill.on_entry = {"note text=\"drill now\"", "toy-resize radius=1.5"};
  drill.transitions = {{"inspect", "request", {{"removed_mm3", 0.5, {}}}},
                       {"mark", "toy-resize", {{"visits mark", {}, 1.0}, {"step_seconds", 0.01, {}}}}};
  volume::ProcedureStep& inspect = procedure.steps[2];
  inspect.name = "inspect";
  inspect.commands = {"*"};
  inspect.transitions = {{"drill", "toy-carve", {{"visits drill", {}, 2.0}}},
                         {"close", "", {{"events toy-marked", 2.0, {}}, {"removed_mm3", {}, 1e6}}}};
  procedure.steps[3].name = "close";
  procedure.steps[3].is_end = true;
  return procedure;
}

struct ProcedureBench : ToyBench {
  std::shared_ptr<const volume::SurgicalPlan> plan;
  explicit ProcedureBench(const volume::SurgicalProcedure& procedure = sample_procedure()) {
    auto planned = std::make_shared<volume::SurgicalPlan>();
    planned->procedure = procedure;
    plan = std::move(planned);
  }
  std::vector<HandStart> hands(std::size_t count) const {
    return std::vector<HandStart>(
        count, HandStart{haptics::ServoHand(haptics::borrowed(scene), haptics::borrowed(*method),
                                            haptics::TouchState(nullptr)),
                         Instrument()});
  }
  Engine planned_engine(std::size_t count = 1) const { return Engine(hands(count), 1e-3, toys(), {}, plan); }
  SessionHeader header(std::size_t count = 1) const {
    SessionHeader header = describe_scene(hands(count), {});
    header.plan = *plan;
    return header;
  }
  std::unique_ptr<SessionWriter> planned_writer(const std::string& path, const WriterOptions& options = {},
                                                std::size_t count = 1) const {
    auto writer = SessionWriter::create(path, header(count), scene.base, toys(), options);
    EXPECT_TRUE(writer.is_ok()) << (writer ? "" : writer.error().message());
    return std::move(writer).value();
  }
};

/// Returns the name of the current step; empty without a procedure.
inline std::string step_of(const Engine& engine) {
  const ProcedurePosition& position = engine.state().undoable.procedure;
  return position.step < 0
             ? ""
             : engine.state().plan->procedure.steps[static_cast<std::size_t>(position.step)].name;
}

/// Returns the events of the procedure from index `first` on as texts, such as "entered drill" or
/// "refused burr in mark".
inline std::vector<std::string> steps_in(const Chronicle& chronicle, std::size_t first = 0) {
  std::vector<std::string> all;
  for (std::size_t i = first; i < chronicle.size(); ++i) {
    const Value& value = chronicle[i].value;
    if (const auto* entered = value.as<StepEntered>()) all.push_back("entered " + entered->step);
    if (const auto* refused = value.as<StepRefused>())
      all.push_back("refused " + refused->request + " in " + refused->step);
  }
  return all;
}

}  // namespace trephine::sim
