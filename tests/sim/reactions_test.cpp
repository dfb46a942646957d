// Modules that react to events and commands: they read the state, and raise further events.
#include "tests/sim/toy_bench.h"

namespace trephine::sim {
namespace {

struct ListenerSettings {
  std::int64_t undos = 0, carved = 0, noted_marks = 0;
  static const Schema& schema() {
    static constexpr Field fields[] = {field<&ListenerSettings::undos>("undos"),
                                       field<&ListenerSettings::carved>("carved"),
                                       field<&ListenerSettings::noted_marks>("noted_marks")};
    static constexpr Schema table{"listener-settings", 1, fields};
    return table;
  }
};
/// Raised once for each command that the listener received.
struct Heard {
  std::string command;
  static const Schema& schema() {
    static constexpr Field fields[] = {field<&Heard::command>("command")};
    static constexpr Schema table{"heard", 1, fields};
    return table;
  }
};
/// Raised in reaction to each event of its own type, until the engine ends the chain.
struct Ping {
  std::int64_t count = 0;
  static const Schema& schema() {
    static constexpr Field fields[] = {field<&Ping::count>("count")};
    static constexpr Schema table{"ping", 1, fields};
    return table;
  }
};

class ListeningModule final : public Module {
 public:
  std::string_view name() const noexcept override { return "listener"; }
  std::span<const ValueType* const> events() const override {
    static const std::array all{&value_type<Heard>(), &value_type<Ping>()};
    return all;
  }
  Value settings() const override { return ListenerSettings{}; }
  void react_to_command(const Command& command, const OperationState& state,
                        ModuleReaction& reaction) const override {
    auto& settings = reaction.change_settings<ListenerSettings>();
    settings.undos += command.request.as<Undo>() != nullptr;
    settings.carved += command.request.as<ToyCarve>() != nullptr;
    // `state` is the state after the command.
    if (command.request.as<ToyMark>()) settings.noted_marks = Toy::toy_undoable(state).marks;
    reaction.raise_event(Heard{std::string(command.request.name())}, glm::dvec3(1, 2, 3));
    if (command.request.as<ToyResize>()) reaction.raise_event(Ping{1}, glm::dvec3(0));
  }
  void react(const Event& event, const OperationState&, ModuleReaction& reaction) const override {
    if (const auto* ping = event.value.as<Ping>()) reaction.raise_event(Ping{ping->count + 1}, glm::dvec3(0));
  }
};

const Catalogue& listeners() {
  static const drilling::Drilling drilling;
  static const Toy toy;
  static const ListeningModule listener;
  static const Catalogue all({&drilling, &toy, &listener});
  return all;
}

TEST(ModuleReaction, ReceivesCommandsAndRaisesEvents) {
  const Folder folder;
  const std::string path = folder.file("heard.session");
  const ToyBench bench;
  std::uint64_t state = 0;
  {
    const SessionHeader header = describe_scene(bench.scene, *bench.method, {}, burr_spec());
    auto writer = SessionWriter::create(path, header, bench.scene.base, listeners());
    ASSERT_TRUE(writer.is_ok()) << writer.error().message();
    Lockstep run(Engine(bench.scene, *bench.method, drilling::burr(k_burr), 1e-3, listeners()), {}, 1000,
                 writer.value().get());
    const auto settings = [&] { return *run.engine().state().persistent_of<ListenerSettings>(); };
    run.step({{0, 0, 40}, {1, 0, 0, 0}, false});
    ASSERT_FALSE(run.apply({ToyMark{dvec3(1)}, 0}).refused);
    ASSERT_FALSE(run.apply({ToyMark{dvec3(2)}, 0}).refused);
    EXPECT_EQ(settings().noted_marks, 2);
    ASSERT_FALSE(run.apply({ToyCarve{dvec3(0)}, 0}).refused);
    run.undo();
    EXPECT_EQ(settings().undos, 1);
    EXPECT_EQ(settings().carved, 1);
    // A refused command is not passed to modules.
    for (int i = 0; i < 12; ++i) run.apply({ToyMark{dvec3(i)}, 0});
    EXPECT_EQ(settings().noted_marks, 10);
    std::vector<std::string> heard;
    const Chronicle& chronicle = run.engine().state().chronicle;
    for (std::size_t i = 0; i < chronicle.size(); ++i)
      if (const auto* event = chronicle[i].value.as<Heard>()) heard.push_back(event->command);
    ASSERT_GE(heard.size(), 4u);
    EXPECT_EQ(heard[0], "toy-mark");
    EXPECT_EQ(heard[2], "toy-carve");
    EXPECT_EQ(heard[3], "undo");
    // The engine ends an endless chain of events after at most a thousand events.
    const Outcome endless = run.apply({ToyResize{2}, 0});
    EXPECT_GE(endless.event_count, 900u);
    EXPECT_LE(endless.event_count, 1000u);
    run.step({{0, 0, 40}, {1, 0, 0, 0}, false});
    state = run.engine().state().hash();
    ASSERT_FALSE(writer.value()->finish(run.engine()));
  }
  const Verdict verdict = replay(path, bench.scene.base, listeners());
  expect_same(verdict);
  EXPECT_EQ(verdict.state, state);
}

}  // namespace
}  // namespace trephine::sim
