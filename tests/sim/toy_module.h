// Toy: a module for tests, with commands, events, jobs, undoable state, settings, a result and measures.
#pragma once

#include <array>
#include <chrono>
#include <glm/geometric.hpp>
#include <thread>

#include "sim/api/module.h"
#include "volume/surface/part_surface.h"

namespace trephine::sim {

struct ToyUndoable {
  std::int64_t marks = 0;
  std::vector<glm::dvec3> places;
  double flooded = 0;  ///< sum of the results of adopted ToyFlood jobs
  static const Schema& schema() {
    static constexpr Field fields[] = {field<&ToyUndoable::marks>("marks"),
                                       field<&ToyUndoable::places>("places"),
                                       field<&ToyUndoable::flooded>("flooded")};
    static constexpr Schema table{"toy-world", 1, fields};
    return table;
  }
};
/// Result of the last adopted ToyFlood.
struct ToyFound {
  double number = 0;
  static const Schema& schema() {
    static constexpr Field fields[] = {field<&ToyFound::number>("number")};
    static constexpr Schema table{"toy-found", 1, fields};
    return table;
  }
};
struct ToySettings {
  double radius = 1;
  std::int64_t heard = 0;  ///< number of events that react() received
  static const Schema& schema() {
    static constexpr Field fields[] = {field<&ToySettings::radius>("radius", {.low = 0.5, .high = 3}),
                                       field<&ToySettings::heard>("heard")};
    static constexpr Schema table{"toy-settings", 1, fields};
    return table;
  }
};

/// Adds a position to ToyUndoable; at most ten are allowed.
struct ToyMark {
  glm::dvec3 at{0.0};
  static const Schema& schema() {
    static constexpr Field fields[] = {field<&ToyMark::at>("at", {.unit = "mm", .low = -100, .high = 100})};
    static constexpr Schema table{"toy-mark", 1, fields};
    return table;
  }
};
/// Removes a ball with the radius of ToySettings.
struct ToyCarve {
  glm::dvec3 at{0.0};
  static const Schema& schema() {
    static constexpr Field fields[] = {field<&ToyCarve::at>("at", {.unit = "mm", .low = -100, .high = 100})};
    static constexpr Schema table{"toy-carve", 1, fields};
    return table;
  }
};
/// Restores all removed matter.
struct ToyMend {
  static const Schema& schema() {
    static constexpr Schema table{"toy-mend"};
    return table;
  }
};
/// Sets the radius of ToySettings.
struct ToyResize {
  double radius = 1;
  static const Schema& schema() {
    static constexpr Field fields[] = {
        field<&ToyResize::radius>("radius", {.unit = "mm", .low = 0.5, .high = 3})};
    static constexpr Schema table{"toy-resize", 1, fields};
    return table;
  }
};
/// Emitted by ToyMark, with the number of positions, and by the adoption of a ToyFlood, with
/// Toy::event_salt.
struct ToyMarked {
  std::int64_t count = 0;
  static const Schema& schema() {
    static constexpr Field fields[] = {field<&ToyMarked::count>("count")};
    static constexpr Schema table{"toy-marked", 1, fields};
    return table;
  }
};
/// A job that takes `milliseconds` (ms) and computes a number from the state in which it started. Its
/// adoption adds the number to ToyUndoable::flooded and removes a ball at the requested position. The result
/// of a strict job is invalid if the amount of removed matter changed after the start of the job.
struct ToyFlood {
  glm::dvec3 at{0.0};
  double milliseconds = 0;
  bool is_strict = false;
  static const Schema& schema() {
    static constexpr Field fields[] = {
        field<&ToyFlood::at>("at", {.unit = "mm", .low = -100, .high = 100}),
        field<&ToyFlood::milliseconds>("milliseconds", {.low = 0, .high = 1e4}),
        field<&ToyFlood::is_strict>("strict")};
    static constexpr Schema table{"toy-flood", 1, fields};
    return table;
  }
};

/// A job that adds implants: `count` titanium cubes with an edge of 1 mm, 1.5 mm apart along x from `at`.
/// They move there from 10 mm above in `seconds` (s), with three turns.
struct ToyPlant {
  glm::dvec3 at{0.0};
  std::int64_t count = 1;
  double seconds = 0;
  bool is_fixed = true;
  static const Schema& schema() {
    static constexpr Field fields[] = {field<&ToyPlant::at>("at", {.unit = "mm", .low = -100, .high = 100}),
                                       field<&ToyPlant::count>("count", {.low = 1, .high = 200}),
                                       field<&ToyPlant::seconds>("seconds", {.low = 0, .high = 10}),
                                       field<&ToyPlant::is_fixed>("fixed")};
    static constexpr Schema table{"toy-plant", 1, fields};
    return table;
  }
};

class Toy final : public Module {
 public:
  std::string_view name() const noexcept override { return "toy"; }
  std::span<const ValueType* const> commands() const override {
    static const std::array<const ValueType*, 4> all{&value_type<ToyMark>(), &value_type<ToyCarve>(),
                                                     &value_type<ToyMend>(), &value_type<ToyResize>()};
    return all;
  }
  std::span<const ValueType* const> events() const override {
    static const std::array<const ValueType*, 1> all{&value_type<ToyMarked>()};
    return all;
  }
  std::span<const JobType* const> jobs() const override {
    static const JobType flood{&value_type<ToyFlood>(), run, is_result_valid, adopt};
    static const JobType plant{&value_type<ToyPlant>(), plant_cubes, nullptr, adopt_nothing};
    static const std::array<const JobType*, 2> all{&flood, &plant};
    return all;
  }
  Value undoable() const override { return ToyUndoable{}; }
  Value settings() const override { return ToySettings{}; }
  Value result() const override { return ToyFound{}; }

  Status allows(const Command& command, const OperationState& now) const override {
    if (command.request.as<ToyMark>() && toy_undoable(now).marks >= 10)
      return Error{.what = "too many marks",
                   .where = "toy-mark",
                   .found = "10",
                   .expected = "at most 10",
                   .remedy = "undo one"};
    return std::nullopt;
  }
  void apply(const Command& command, ModuleWork& work) const override {
    if (const auto* mark = command.request.as<ToyMark>()) {
      ToyUndoable& changed = work.change_undoable<ToyUndoable>();
      changed.marks += 1;
      changed.places.push_back(mark->at);
      work.raise_event(ToyMarked{changed.marks}, mark->at);
    } else if (const auto* carve = command.request.as<ToyCarve>()) {
      work.remove({carve->at, carve->at, work.settings<ToySettings>().radius, false});
    } else if (command.request.as<ToyMend>()) {
      work.restore_all();
    } else if (const auto* resize = command.request.as<ToyResize>()) {
      work.change_settings<ToySettings>().radius = resize->radius;
    }
  }
  void react(const Event&, const OperationState&, ModuleReaction& state) const override {
    ++state.change_settings<ToySettings>().heard;
  }
  std::vector<Measure> measures(const OperationState& now) const override {
    const ToyFound* found = now.result_of<ToyFound>();
    return {{"marks", static_cast<double>(toy_undoable(now).marks), ""},
            {"found", found ? found->number : 0, "", now.is_result_stale<ToyFound>()}};
  }

  /// Planted faults: the result of a ToyFlood also depends on `salt`, and the event of its adoption has
  /// `event_salt` as its count.
  static inline double salt = 0;
  static inline std::int64_t event_salt = 0;

  /// Returns the undoable state of this module; the initial one if the operation lacks the module.
  static const ToyUndoable& toy_undoable(const OperationState& state) {
    static const ToyUndoable initial;
    const ToyUndoable* found = state.undoable_of<ToyUndoable>();
    return found ? *found : initial;
  }

 private:
  struct Planted final : JobResult {
    std::vector<NewBody> cubes;
    std::uint64_t hash() const override {
      MixHash all;
      for (const NewBody& cube : cubes) all.add(cube.piece->hash), all.add(cube.placement.position_world.x);
      return all.value();
    }
    std::span<const NewBody> bodies() const noexcept override { return cubes; }
  };
  static std::shared_ptr<const JobResult> plant_cubes(const void* parameters, const JobInput&) {
    const auto& request = *static_cast<const ToyPlant*>(parameters);
    volume::PartSurface surface;
    for (int i = 0; i < 8; ++i)
      surface.vertices_world.emplace_back(i & 1 ? 0.5 : -0.5, i & 2 ? 0.5 : -0.5, i & 4 ? 0.5 : -0.5);
    surface.triangles = {0, 2, 1, 1, 2, 3, 4, 5, 6, 5, 7, 6, 0, 1, 4, 1, 5, 4,
                         2, 6, 3, 3, 6, 7, 0, 4, 2, 2, 4, 6, 1, 3, 5, 3, 7, 5};
    auto output = std::make_shared<Planted>();
    for (std::int64_t i = 0; i < request.count; ++i) {
      NewBody cube;
      cube.piece = std::make_shared<const Piece>(surface, haptics::Material());
      cube.placement.position_world = request.at + glm::dvec3(1.5 * static_cast<double>(i), 0, 0);
      cube.is_fixed = request.is_fixed;
      cube.motion.from = cube.placement;
      cube.motion.from.position_world.z += 10;
      cube.motion.seconds = request.seconds, cube.motion.turns = 3;
      output->cubes.push_back(std::move(cube));
    }
    return output;
  }
  static void adopt_nothing(const void*, const JobResult&, ModuleWork&) {}
  struct Made final : JobResult {
    double number = 0;
    std::uint64_t hash() const override {
      MixHash all;
      all.add(number);
      return all.value();
    }
  };
  static std::shared_ptr<const JobResult> run(const void* parameters, const JobInput& input) {
    std::this_thread::sleep_for(
        std::chrono::duration<double, std::milli>(static_cast<const ToyFlood*>(parameters)->milliseconds));
    auto output = std::make_shared<Made>();
    output->number = static_cast<double>(input.state.undoable.version->content_hash() >> 12) +
                     static_cast<double>(toy_undoable(input.state).marks) + salt;
    return output;
  }
  static bool is_result_valid(const void* parameters, const OperationState& input,
                              const OperationState& now) {
    return !static_cast<const ToyFlood*>(parameters)->is_strict ||
           input.undoable.version->ledger().total() == now.undoable.version->ledger().total();
  }
  static void adopt(const void* parameters, const JobResult& result, ModuleWork& work) {
    work.change_undoable<ToyUndoable>().flooded += static_cast<const Made&>(result).number;
    work.change_result<ToyFound>().number = static_cast<const Made&>(result).number;
    work.raise_event(ToyMarked{event_salt}, glm::dvec3(0));
    const glm::dvec3& at = static_cast<const ToyFlood*>(parameters)->at;
    work.remove({at, at, 0.8, false});
  }
};

}  // namespace trephine::sim
