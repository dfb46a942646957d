// ToyBench: the toy module and drilling on the small bone, with random valid and invalid commands.
#pragma once

#include <random>

#include "tests/sim/session_fixture.h"
#include "tests/sim/toy_module.h"

namespace trephine::sim {

/// Returns a catalogue with the drilling module and the toy module.
inline const Catalogue& toys() {
  static const drilling::Drilling drilling;
  static const Toy toy;
  static const Catalogue all({&drilling, &toy});
  return all;
}

/// A command that no module knows.
struct Stranger {
  static const Schema& schema() {
    static constexpr Schema table{"stranger"};
    return table;
  }
};

struct ToyBench {
  haptics::TouchScene scene = small_bone();
  std::unique_ptr<haptics::ProxyMethod> method = haptics::make_method("subvoxel").value();
  ToyBench() { EXPECT_FALSE(method->prepare(scene)); }
  Engine engine() const { return Engine(scene, *method, drilling::burr(k_burr), 1e-3, toys()); }
  std::unique_ptr<SessionWriter> toy_writer(const std::string& path,
                                            const WriterOptions& options = {}) const {
    const SessionHeader header = describe_scene(scene, *method, {}, burr_spec());
    return SessionWriter::create(path, header, scene.base, toys(), options).value();
  }
};

inline dvec3 random_position(std::mt19937& random) {
  std::uniform_real_distribution<double> along(-6, 6), up(-2, 2);
  const double x = along(random), y = along(random), z = up(random);
  return {x, y, z};
}

inline constexpr const char* k_effects[] = {"", "viscous damping=0.001", "spring anchor=0,0,3 stiffness=0.05",
                                            "spring anchor=nowhere", "magic"};

inline constexpr const char* k_branches[] = {"main", "second", "third", "", "two\nlines"};

/// Returns a valid or invalid command at random.
inline Command random_command(std::mt19937& random, const std::vector<PendingJob>& jobs) {
  switch (random() % 18) {
    case 0:
    case 1:
      return Undo{};
    case 2:
      return Redo{};
    case 3:
    case 4:
      return ToyMark{random_position(random)};
    case 5:
      return ToyCarve{random_position(random)};
    case 6:
      return random() % 4 == 0 ? Command(ToyMend{})
                               : Command(ToyResize{0.5 + 0.25 * static_cast<double>(random() % 8)});
    case 7:
      return ToyFlood{random_position(random), 0, random() % 2 == 0};
    case 8:
    case 9:
      if (jobs.empty()) return AdoptJob{{4711}};
      return random() % 4 == 0 ? Command(CancelJob{jobs[random() % jobs.size()].id})
                               : Command(AdoptJob{jobs[random() % jobs.size()].id});
    case 10:
      return drilling::Burr{2 + 0.5 * static_cast<double>(random() % 6), 60, 40};
    case 11:
      return random() % 2 == 0 ? Command(drilling::Burr{-1}) : Command(ToyMark{dvec3(1e5)});
    case 12:
      return random() % 3 == 0   ? Command(Stranger{})
             : random() % 2 == 0 ? Command(FaultEvent{"an event sent as a request"})
                                 : Command(Undo{}, 3);
    case 13:
      return random() % 2 == 0
                 ? Command(SwitchItem{static_cast<std::int64_t>(random() % 3), random() % 3 != 0})
                 : Command(SetEffect{{static_cast<std::uint32_t>(random() % 3)},
                                     k_effects[random() % std::size(k_effects)]});
    case 14:  // expensive: it builds fields
      if (random() % 8 != 0) return Note{"nothing"};
      return ToolGeometry{random() % 2 == 0 ? 0.0 : 0.5 + 0.25 * static_cast<double>(random() % 3)};
    case 15:
      return BeginBranch{k_branches[random() % std::size(k_branches)]};
    case 16:
      return SwitchBranch{k_branches[random() % std::size(k_branches)]};
    default:
      return Note{"a remark"};
  }
}

/// Returns the command. As a live operation does, sets the hash of an AdoptJob to that of the job's result,
/// or to 0 if the result is no longer valid.
inline Command with_hash(Command command, const Engine& engine) {
  if (auto* adopt = command.request.as<AdoptJob>())
    for (const PendingJob& job : engine.jobs())
      if (job.id == adopt->job) {
        const bool fits =
            !job.type || job.type->is_result_valid(job.parameters->data(), *job.input, engine.state());
        adopt->hash = fits ? static_cast<std::int64_t>(job.run()->hash()) : 0;
      }
  return command;
}

}  // namespace trephine::sim
