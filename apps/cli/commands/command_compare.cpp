// compare: two states of a session side by side, and their difference.
#include <array>

#include "apps/cli/commands.h"
#include "apps/view/comparison.h"
#include "data-tools/files/atomic_file.h"
#include "data-tools/files/output_set.h"

namespace trephine::cli {

namespace {

struct CompareArguments {
  workbench::SourceChoice case_source;
  std::string session, output;
  std::optional<double> at;    ///< time of the first state, s; nullopt: the uncut scan
  std::optional<double> with;  ///< time of the second state, s; nullopt: the end
};

/// Returns the state at a tick, with its title.
Result<view::ComparedState> state_at(sim::Replay& replay, std::uint64_t tick, double rate,
                                     sim::SessionReader& reader) {
  if (Status error = replay.seek(tick)) return *error;
  sim::Engine& engine = replay.engine();
  engine.freeze();
  view::ComparedState state;
  state.title = format_text("%s, %.1f s, %zu stroke%s", engine.branch().name.c_str(),
                            static_cast<double>(std::min(tick, reader.tick_count())) / rate,
                            engine.stroke_count(), engine.stroke_count() == 1 ? "" : "s");
  state.version = engine.version();
  state.overlays = engine.overlays();
  return state;
}

Result<Outcome> run_compare(const CompareArguments& arguments) {
  data_tools::OutputSet outputs;
  for (const std::string& input : {arguments.session, arguments.case_source.path}) outputs.add_input(input);
  outputs.add_output("output", arguments.output, data_tools::OutputKind::picture);
  if (Status error = outputs.check()) return *error;
  for (const double time : {arguments.at.value_or(0), arguments.with.value_or(0)})
    if (!(time >= 0))
      return Error{.what = "the time is out of range",
                   .where = "--time, --with",
                   .found = std::to_string(time),
                   .expected = "0 s or more"};
  auto opened = workbench::open_session(arguments.session, arguments.case_source, terminal_listener());
  if (!opened) return opened.error();
  workbench::OpenedSession& session = *opened.value();
  const double rate = session.reader->header().rate_hz;
  const std::uint64_t tick_count = session.reader->tick_count();
  for (const double time : {arguments.at.value_or(0), arguments.with.value_or(0)})
    if (time * rate > static_cast<double>(tick_count) + 0.5)
      return Error{.what = "the session ends before this time",
                   .where = "--time, --with",
                   .found = format_text("%.1f s", time),
                   .expected = format_text("0 to %.1f s", static_cast<double>(tick_count) / rate)};
  const auto tick_of = [&](std::optional<double> time) {
    return time ? std::min(tick_count, static_cast<std::uint64_t>(std::llround(*time * rate))) : tick_count;
  };
  std::array<std::size_t, 2> bodies{};
  // Commands may precede the first tick, so the uncut state may differ from the state at 0 s.
  const auto first_state = [&]() -> Result<view::ComparedState> {
    if (!arguments.at) {
      view::ComparedState uncut;
      uncut.title = "uncut";
      uncut.version = session.replay->engine().uncut();
      return uncut;
    }
    auto state = state_at(*session.replay, tick_of(arguments.at), rate, *session.reader);
    bodies[0] = session.replay->engine().state().undoable.bodies.size();
    return state;
  };
  auto first = first_state();
  if (!first) return first.error();
  auto second = state_at(*session.replay, tick_of(arguments.with), rate, *session.reader);
  if (!second) return second.error();
  bodies[1] = session.replay->engine().state().undoable.bodies.size();
  if (session.scene().items.empty() || session.scene().items[0].is_mesh())
    return Error{.what = "the session has no bone",
                 .where = "session",
                 .expected = "a session whose first shape is of a volume"};
  const view::Difference difference =
      view::difference_between(session.scene(), *first.value().version, *second.value().version);
  Outcome outcome("compare");
  outcome.json["first"] = first.value().title;
  outcome.json["second"] = second.value().title;
  outcome.json["bodies_in_first"] = bodies[0];
  outcome.json["bodies_in_second"] = bodies[1];
  outcome.json["only_in_first_mm3"] = difference.first_mm3;
  outcome.json["only_in_second_mm3"] = difference.second_mm3;
  if (difference.is_any()) outcome.json["middle_world_mm"] = json_of(difference.middle_world);
  outcome.print("first: {first}");
  outcome.print("second: {second}");
  outcome.print(
      "only in the first: {only_in_first_mm3:.1f} mm³, only in the second: {only_in_second_mm3:.1f} mm³");
  if (bodies[0] + bodies[1] > 0)
    outcome.print(
        "detached bodies do not count as bone: {bodies_in_first} in the first, {bodies_in_second} in the "
        "second");
  outputs.write(arguments.output, [&]() -> Status {
    const auto png = view::compare(session.scene(), first.value(), second.value());
    return png ? data_tools::write_file_atomically(arguments.output, png.value()) : Status(png.error());
  });
  return finished(outputs, std::move(outcome));
}

Run build_compare(Options& options) {
  auto a = std::make_shared<CompareArguments>();
  add_session(options, a->session, a->case_source);
  options.add("--time", a->at, "Time of the first state (default: the uncut scan)").type("S");
  options.add("--with", a->with, "Time of the second state (default: the end)").type("S");
  options.add("-o,--output", a->output, "Write a picture of both, side by side").type("PNG");
  return run_with(a, run_compare);
}

}  // namespace

const Command k_compare{"compare", "Show two states of a session side by side, and their difference",
                        "  trephine compare drill.session -o compared.png\n"
                        "  trephine compare drill.session --time 8.2 --with 12 --json",
                        build_compare};

}  // namespace trephine::cli
