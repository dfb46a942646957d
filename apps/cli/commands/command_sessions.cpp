// replay and resume: repeat a recorded session, and continue it.
#include <cmath>
#include <fstream>

#include "apps/cli/commands.h"
#include "apps/cli/commands/session_window.h"
#include "apps/cli/commands/steps_csv.h"
#include "apps/cli/commands/window_devices.h"
#include "apps/view/render_window.h"
#include "apps/view/view_window.h"
#include "apps/workbench/continued_session.h"
#include "data-tools/files/atomic_file.h"
#include "data-tools/files/output_set.h"
#include "data-tools/formats/open_volume.h"
#include "data-tools/meshes/mesh_files.h"
#include "modules/catalogue.h"
#include "sim/drivers/lockstep.h"
#include "sim/session/session_fork.h"
#include "volume/surface/surface_nets.h"

namespace trephine::cli {

namespace {

struct ReplayArguments {
  workbench::SourceChoice case_source;
  std::string session, output, mesh, steps, screenshot;
  std::optional<double> until;
  bool is_verifying = false, wants_window = false;
  std::string companion;
  DisplayArguments display;
};
struct ResumeArguments {
  workbench::SourceChoice case_source;
  std::string session, path;
  std::optional<double> at;
  std::string record;  ///< file of the new session; required with `at`, and only allowed with it
  workbench::DeviceChoice device;
  DisplayArguments display;
};

/// Returns the remaining surfaces of all shapes of the scan, joined in one mesh (volume frame).
volume::Mesh surface_of(const sim::Engine& engine) {
  const haptics::TouchScene& scene = engine.scene();
  std::vector<volume::Mesh> parts;
  for (const haptics::TouchItem& item : scene.items)
    if (!item.is_mesh() && &item.field.volume() == scene.base.get())
      parts.push_back(volume::surface_net({&item.field, engine.version().get(), item.bits.get()}));
  std::size_t vertices = 0, triangles = 0;
  for (const volume::Mesh& part : parts) vertices += part.vertices.size(), triangles += part.triangles.size();
  volume::Mesh all{Buffer<glm::vec3>(vertices), Buffer<std::uint32_t>(triangles)};
  vertices = triangles = 0;
  for (const volume::Mesh& part : parts) {
    for (const std::uint32_t v : part.triangles.span())
      all.triangles[triangles++] = static_cast<std::uint32_t>(vertices) + v;
    for (const glm::vec3& v : part.vertices.span()) all.vertices[vertices++] = v;
  }
  return all;
}

Result<Outcome> run_replay(const ReplayArguments& arguments) {
  if (!arguments.companion.empty() && !arguments.wants_window)
    return Error{.what = "two sessions are played in windows only",
                 .where = "--with",
                 .expected = "--show --with SESSION",
                 .remedy = "add --show"};
  if (arguments.wants_window &&
      (arguments.is_verifying || arguments.until || !arguments.output.empty() || !arguments.mesh.empty() ||
       !arguments.steps.empty() || !arguments.screenshot.empty()))
    return Error{.what = "--show cannot be combined with options that compare, stop or write",
                 .where = "--show",
                 .found = "--verify, --until, -o, --mesh, --table or --screenshot in addition",
                 .expected = "--show alone",
                 .remedy = "omit --show, or the other options"};
  data_tools::OutputSet outputs;
  for (const std::string& input : {arguments.session, arguments.case_source.path}) outputs.add_input(input);
  outputs.add_output("output", arguments.output, data_tools::OutputKind::volume);
  outputs.add_output("mesh", arguments.mesh, data_tools::OutputKind::mesh);
  outputs.add_output("steps", arguments.steps, data_tools::OutputKind::table);
  outputs.add_output("screenshot", arguments.screenshot, data_tools::OutputKind::picture);
  if (Status error = outputs.check()) return *error;
  if (arguments.until && !(*arguments.until >= 0 && std::isfinite(*arguments.until)))
    return Error{.what = "the time is out of range",
                 .where = "--until",
                 .found = format_text("%g", *arguments.until),
                 .expected = "0 s or more"};
  auto opened = workbench::open_session(arguments.session, arguments.case_source, terminal_listener());
  if (!opened) return opened.error();
  workbench::OpenedSession& session = *opened.value();
  sim::Replay& replay = *session.replay;
  const double rate = session.reader->header().rate_hz;
  if (arguments.is_verifying)
    if (Status error = replay.reason_not_verifiable()) {
      error->where = data_tools::file_name(arguments.session);
      return *error;
    }
  if (arguments.is_verifying) replay.verify_checkpoints();

  if (arguments.wants_window) {
    std::unique_ptr<workbench::OpenedSession> companion;
    Playback second;
    if (!arguments.companion.empty()) {
      const auto scan = scan_for(arguments.companion, arguments.case_source.path);
      if (!scan) return scan.error();
      auto other = workbench::open_session(arguments.companion, scan.value(), terminal_listener());
      if (!other) return other.error();
      companion = std::move(other).value();
      second = {arguments.companion, scan.value(), companion->source.written_name()};
    }
    if (Status error =
            play_in_window(session, {arguments.session, arguments.case_source, session.source.written_name()},
                           arguments.display, companion.get(), second))
      return *error;
    return Outcome("replay", is_interrupted() ? exit_interrupted : exit_done);
  }
  const std::uint64_t tick_count = session.reader->tick_count();
  const std::uint64_t end =
      arguments.until
          ? std::min(tick_count, static_cast<std::uint64_t>(std::llround(*arguments.until * rate)))
          : tick_count;
  ProgressLine progress("replaying");
  std::string csv = arguments.steps.empty() ? "" : k_steps_header;
  double strongest = 0;
  const auto start = Clock::now();
  // The state at one moment is opened by seeking. A table of steps and a verification need every tick before
  // this moment, and thus a replay.
  const bool is_seeking = end < tick_count && arguments.steps.empty() && !arguments.is_verifying;
  if (is_seeking)
    if (Status error = replay.seek(end)) return *error;
  for (std::uint64_t n = 0; replay.next_tick() < end || end == tick_count;
       ++n) {  // commands may follow the last tick
    if (n % 1024 == 0 && !progress(static_cast<double>(replay.next_tick()) /
                                   static_cast<double>(std::max<std::uint64_t>(end, 1))))
      return interrupted("the replay");
    const Result<bool> stepped = replay.step();
    if (!stepped) return stepped.error();
    if (!stepped.value()) break;
    const haptics::ServoRecord& r = replay.record();
    strongest = std::max(strongest, glm::length(r.force_world));
    if (!arguments.steps.empty())
      append_step(csv, r.t, r,
                  r.has_contact ? haptics::name_of(haptics::item_of(session.scene(), r.shape)) : "");
  }
  const double seconds = seconds_since(start);
  const sim::Engine& engine = replay.engine();
  const std::uint64_t hash = engine.version()->content_hash();
  std::optional<sim::Mismatch> mismatch = replay.mismatch();
  if (session.reader->is_damaged() && !mismatch)
    mismatch = sim::Mismatch{tick_count, "file",
                             format_text("damaged at byte %llu",
                                         static_cast<unsigned long long>(session.reader->complete_bytes())),
                             "everything before that is the same"};
  // A session that was truncated after its header has nothing to compare; this counts as a mismatch.
  if (!mismatch && end > 0 && replay.counts().ticks == 0 && replay.counts().commands == 0)
    mismatch = sim::Mismatch{0, "session", "neither ticks nor commands", "nothing to compare"};
  outputs.write(arguments.steps, [&] { return data_tools::write_file_atomically(arguments.steps, csv); });
  notify_resampled(*session.source.volume, arguments.output);
  outputs.write(arguments.output,
                [&] { return data_tools::write_operated(arguments.output, *engine.version()); });
  outputs.write(arguments.mesh, [&] {
    return data_tools::write_mesh(arguments.mesh, surface_of(engine), session.scene().base->frame);
  });
  outputs.write(arguments.screenshot, [&]() -> Status {
    view::WindowOptions options;
    options.should_close = is_interrupted;
    options.screenshot = arguments.screenshot;
    options.title = session.source.written_name();
    options.is_offscreen = true;
    options.version = engine.version();
    options.replay = session.replay.get();
    options.plan = std::make_shared<const volume::SurgicalPlan>(session.reader->header().plan);
    auto summary = workbench::summarize_session(arguments.session);
    if (!summary) return summary.error();
    options.summary = std::move(summary).value();
    const auto shown = view::run_window(view::borrowed(session.scene()), options);
    return shown ? std::nullopt : Status(shown.error());
  });

  const sim::Replay::Counts& counts = replay.counts();
  Outcome outcome("replay");
  Json& json = outcome.json;
  json["ticks"] = is_seeking ? replay.next_tick() : counts.ticks;
  json["dropped_ticks"] = counts.dropped;
  json["commands"] = counts.commands;
  json["versions"] = counts.versions;
  json["checkpoints"] = counts.checkpoints;
  json["changes"] = engine.stroke_count();
  Json branches = Json::array({engine.branch().name});
  for (const sim::Branch& branch : engine.other_branches()) branches.push_back(branch.name);
  json["branches"] = branches;
  json["history_bytes"] = engine.history_bytes();
  json["removed_mm3_total"] = engine.removed_mm3();
  json["content_hash"] = hash_text(hash);
  json["strongest_force_n"] = is_seeking ? Json() : Json(strongest);
  const haptics::EnergyLedger& energy = replay.record().energy;
  json["energy_n_mm"] = {
      {"contact", energy.contact}, {"growth", energy.growth}, {"growth_discarded", energy.discarded}};
  json["replay_seconds"] = seconds;
  json["speed"] = seconds > 0 ? static_cast<double>(replay.next_tick()) / rate / seconds : 0;
  json["is_closed"] = session.reader->end().has_value();
  const Json moment = {{"at", static_cast<double>(replay.next_tick()) / rate}};
  outcome.print(is_seeking
                    ? "opened at {at:.1f} s in {replay_seconds:.2f} s; strokes: {changes}, removed: "
                      "{removed_mm3_total:.2f} mm³"
                    : "{at:.1f} s replayed in {replay_seconds:.2f} s; commands: {commands}, strokes: "
                      "{changes}, removed: {removed_mm3_total:.2f} mm³, at most {strongest_force_n:.2f} N",
                moment);
  if (arguments.is_verifying) {
    json["is_same"] = !mismatch.has_value();
    if (mismatch) {
      json["mismatch"] = {{"tick", mismatch->tick},
                          {"what", mismatch->what},
                          {"recorded", mismatch->recorded},
                          {"replayed", mismatch->replayed}};
      outcome.print("NOT the same: {what} at tick {tick}", json["mismatch"]);
      outcome.print("  recorded: {recorded}", json["mismatch"]);
      outcome.print("  replayed: {replayed}", json["mismatch"]);
      outcome.exit_code = exit_check_failed;
    } else {
      json["is_complete"] = session.reader->end().has_value();
      if (!session.reader->end())
        outcome.print(
            "the session has no end, since the program was stopped: only the recorded part is compared");
      outcome.print(
          "the same to the bit: {forces} forces, {versions} versions, {checkpoints} checkpoints, voxel hash "
          "{content_hash}",
          {{"forces", counts.ticks}});
    }
  }
  return finished(outputs, std::move(outcome));
}

/// Copies the session up to the chosen time into the file `record`, which run_resume() then continues.
Status fork(const ResumeArguments& arguments) {
  if (arguments.record.empty())
    return Error{.what = "no file for the new session",
                 .where = "--record",
                 .expected = "--record FILE with --at S",
                 .remedy = "to continue the session at its end, omit --at"};
  if (!(*arguments.at >= 0 && *arguments.at <= 1e6))
    return Error{.what = "the time is out of range",
                 .where = "--at",
                 .found = format_text("%g s", *arguments.at),
                 .expected = "0 to 1000000 s"};
  workbench::RecordChoice record;
  record.file = arguments.record;
  if (Status error = check(record)) return error;
  const auto reader = sim::SessionReader::open(arguments.session, modules::catalogue());
  if (!reader) return reader.error();
  const double rate = reader.value().header().rate_hz;
  const auto ticks = sim::fork_session(
      arguments.session, static_cast<std::uint64_t>(std::llround(*arguments.at * rate)), arguments.record);
  return ticks ? Status() : Status(ticks.error());
}

Result<Outcome> run_resume(const ResumeArguments& arguments) {
  if (arguments.path.empty() && !view::has_display()) {
    Error error = view::no_display();
    error.remedy = "without a display, pass a path to continue with: --path PATH.csv";
    return error;
  }
  std::optional<haptics::PosePath> path;
  if (!arguments.path.empty()) {
    auto read = workbench::open_path(arguments.path);
    if (!read) return read.error();
    path = std::move(read).value();
  }
  workbench::DeviceChoice choice = arguments.device;
  if (path) {
    if (!choice.device.empty() || !choice.left.empty() || !choice.pedal.empty())
      return Error{.what = "a path replaces the devices",
                   .where = "--path",
                   .remedy = "omit the path, or the devices"};
    choice.device = "mouse";  // not the device of devices.toml
  }
  const auto devices = open_window_devices(choice, arguments.display.language, !path.has_value());
  if (!devices) return devices.error();
  std::string file = arguments.session;
  if (arguments.at) {
    if (Status error = fork(arguments)) return *error;
    file = arguments.record;
  } else if (!arguments.record.empty()) {
    return Error{.what = "a new session needs a time at which it begins",
                 .where = "--record",
                 .expected = "--at S with --record FILE"};
  }
  auto continued =
      workbench::continue_session(file, arguments.case_source, !path.has_value(), terminal_listener(),
                                  workbench::hand_count_of(devices.value()));
  if (!continued) {
    if (arguments.at) std::filesystem::remove(arguments.record);  // the copy that cannot be continued
    return continued.error();
  }
  const sim::SessionHeader& header = continued.value().header();
  sim::SessionWriter& writer = *continued.value().writer;
  sim::Engine& engine = continued.value().engine;
  const std::uint64_t first_tick = continued.value().first_tick;
  const double before = engine.removed_mm3();

  Outcome outcome("resume");
  outcome.json["from_seconds"] = static_cast<double>(first_tick) / header.rate_hz;
  outcome.json["removed_mm3_before"] = before;
  double after = 0;
  if (path) {
    sim::Lockstep run(std::move(engine), header.force, header.rate_hz, &writer, first_tick);
    ProgressLine progress("continuing");
    const std::vector<double> times = haptics::servo_times(*path, header.rate_hz);
    for (std::size_t i = 0; i < times.size(); ++i) {
      if (i % 256 == 0 && !progress(static_cast<double>(i) / static_cast<double>(times.size()))) break;
      run.step(path->at(times[i]));
    }
    if (Status error = writer.finish(run.engine())) return *error;
    after = run.engine().removed_mm3();
    if (is_interrupted()) {
      Error error = interrupted("continuing");
      error.what = "interrupted; the session contains everything that was done";
      return error;
    }
  } else {
    auto shown = continue_in_window(std::move(continued).value(), arguments.case_source.path,
                                    {file, arguments.session, arguments.case_source.path}, devices.value(),
                                    arguments.display);
    if (!shown) return shown.error();
    after = shown.value().removed_mm3;
  }
  outcome.json["removed_mm3_total"] = after;
  outcome.print(
      "continued at {from_seconds:.1f} s; removed {removed_mm3_before:.2f} mm³ before, "
      "{removed_mm3_total:.2f} mm³ now");
  return outcome;
}

Run build_replay(Options& options) {
  auto a = std::make_shared<ReplayArguments>();
  add_session(options, a->session, a->case_source);
  options.add("--show", a->wants_window, "Play it in the window: pause, seek, speed, forces");
  options.add("--with", a->companion, "With --show: play another session next to it, on the same clock")
      .type("SESSION");
  options.add("--verify", a->is_verifying, "Compare every force, volume and voxel with the recording");
  options.add("--until", a->until, "Stop at this time, s").type("S");
  options.add("-o,--output", a->output,
              "Write the remaining volume at that time: " +
                  data_tools::extensions_of(data_tools::OutputKind::volume));
  options
      .add("--mesh", a->mesh,
           "Write the remaining surface of the touched shapes at that time: " +
               data_tools::extensions_of(data_tools::OutputKind::mesh))
      .type("MESH");
  options.add("--table", a->steps, "Write a row for every tick").type("STEPS.csv");
  options.add("--screenshot", a->screenshot, "Write a picture of the state at that time").type("OUT.png");
  add_display(options, a->display);
  return run_with(a, run_replay);
}

Run build_resume(Options& options) {
  auto a = std::make_shared<ResumeArguments>();
  add_session(options, a->session, a->case_source);
  options.add("--path", a->path, "Continue with a path instead of a window").type("PATH.csv");
  options
      .add("--at", a->at,
           "Continue a copy of the session from this time instead of the end; the copy ends at the last "
           "complete block of the log, up to 1000 ticks before this time")
      .type("S");
  options.add("--record", a->record, "The new session, with --at").type("FILE");
  add_devices(options, a->device);
  add_display(options, a->display);
  return run_with(a, run_resume);
}

}  // namespace

const Command k_replay{
    "replay", "Run a recorded session again",
    "  trephine replay drill.session --verify\n"
    "  trephine replay drill.session --scan head-case --until 12.5 -o then.mha --screenshot then.png",
    build_replay};
const Command k_resume{"resume", "Continue a session where it stopped, or a copy of its first part",
                       "  trephine resume drill.session\n  trephine resume drill.session --path path.csv\n"
                       "  trephine resume drill.session --at 12.5 --record other-hand.session",
                       build_resume};

}  // namespace trephine::cli
