// soak: hours of live drilling with undo, by a scripted hand; then a replay of its session.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <glm/geometric.hpp>
#include <random>
#include <thread>

#include "apps/bench/commands/bench_commands.h"
#include "data-tools/files/atomic_file.h"
#include "modules/drilling/burr.h"
#include "sim/drivers/live_session.h"
#include "volume/base/text.h"
#include "volume/scan/traversal.h"

namespace trephine::bench {

using namespace cli;

using glm::dvec3;

namespace {

struct SoakArguments {
  workbench::SourceChoice source = "head";
  std::string session;
  workbench::ShapeChoice shape;
  double seconds = 3600, rate = 1000;
  std::uint64_t seed = 1;
};

/// Returns strokes all over the outside of the bone, for `seconds` in total. In each stroke the hand moves to
/// the first hit of a ray from outside, presses and drags for half a second, and lifts the tool.
Result<haptics::PosePath> random_strokes(const haptics::TouchScene& scene, double seconds,
                                         std::uint64_t seed) {
  const volume::Volume& base = *scene.base;
  const volume::Frame& frame = base.frame;
  const dvec3 middle = frame.world_from_volume(0.5 * dvec3(base.size - 1));
  const double reach = glm::length(frame.vector_world_from_volume(dvec3(base.size)));
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> uniform(-1, 1);
  const auto direction = [&] {
    dvec3 d;
    do d = {uniform(random), uniform(random), uniform(random)};
    while (glm::dot(d, d) > 1 || glm::dot(d, d) < 0.01);
    return glm::normalize(d);
  };
  std::vector<haptics::PosePath::Sample> samples;
  const auto add = [&samples](double t, const dvec3& p, bool is_pressed) {
    samples.push_back({t, {p, {1, 0, 0, 0}, is_pressed}});
  };
  double t = 0;
  for (int misses = 0; t < seconds;) {
    const dvec3 out = direction(),
                aim = middle + 0.25 * reach * dvec3(uniform(random), uniform(random), uniform(random)) * 0.5;
    const dvec3 start = aim + reach * out, end = aim - reach * out;
    double hit = -1;
    volume::traverse(frame.volume_from_world(start), frame.volume_from_world(end),
                     {glm::ivec3(0), base.size - 1}, [&](const volume::VoxelVisit& v) {
                       if (!scene.items[0].bits->is_solid(v.voxel)) return true;
                       hit = v.t_enter;
                       return false;
                     });
    if (hit < 0) {
      if (++misses > 10000)
        return Error{.what = "no ray from outside meets the shape",
                     .remedy = "choose another threshold, range or label"};
      continue;
    }
    const dvec3 point = start + hit * (end - start), side = glm::normalize(glm::cross(out, direction()));
    add(t, point + 12.0 * out, false);
    add(t + 0.15, point + 1.0 * out, false);
    add(t + 0.2, point, true);
    add(t + 0.45, point - 2.5 * out, true);
    add(t + 0.7, point - 2.5 * out + 6.0 * side, true);
    add(t + 0.72, point - 1.0 * out + 6.0 * side, false);
    add(t + 0.8, point + 12.0 * out + 6.0 * side, false);
    t += 1.0;
  }
  return haptics::PosePath::from_samples(std::move(samples), "soak");
}

Result<Outcome> run_soak(const SoakArguments& arguments) {
  if (!(arguments.seconds >= 10 && arguments.seconds <= 1e6))
    return Error{.what = "the time is out of range",
                 .where = "--seconds",
                 .found = rounded_text(arguments.seconds),
                 .expected = "10 to 1000000 s"};
  if (!(arguments.rate >= 250 && arguments.rate <= 10000))
    return Error{.what = "the rate is out of range",
                 .where = "--rate",
                 .found = rounded_text(arguments.rate),
                 .expected = "250 to 10000 Hz"};
  workbench::RecordChoice record;
  record.program = program_name();
  record.file = arguments.session.empty() ? workbench::autosave_path() : arguments.session;
  if (record.file.empty())
    return Error{.what = "the session cannot be created",
                 .found = "no writable folder in HOME or XDG_STATE_HOME",
                 .remedy = "set XDG_STATE_HOME to a writable folder, or pass --record FILE"};
  if (Status error = check(record)) return *error;
  drilling::Burr burr;
  constexpr double k_smallest = 2;  // mm, smallest diameter of the burrs below
  workbench::OperationChoice choice;
  choice.procedure_use = workbench::ProcedureUse::ignored;
  choice.shape = arguments.shape;
  choice.hands[0] = sim::HandSpec(drilling::burr(burr));
  choice.rate_hz = arguments.rate;
  choice.smallest_burr = k_smallest;
  auto opened = workbench::open_operation(arguments.source, choice, terminal_listener());
  if (!opened) return opened.error();
  const workbench::Operation& operation = opened.value();
  const workbench::Source& source = operation.source;
  auto path = random_strokes(*operation.scene(), arguments.seconds, arguments.seed);
  if (!path) return path.error();

  record.is_embedding = !source.is_builtin;
  haptics::VirtualDevice device(path.value(), {});
  auto recorder = workbench::start_recording(record, operation);
  if (!recorder) return recorder.error();
  haptics::Device* const devices[] = {&device};
  sim::LiveSession live(devices, operation.engine(), operation.servo(), recorder.value().get());
  if (Status error = live.start()) return *error;

  // After ten strokes, all strokes are undone. With more than three strokes, the newest is undone at random
  // times in contact. After the undo, a redo may follow at random, and the burr gets another diameter.
  std::mt19937_64 random(arguments.seed + 1);
  std::vector<double> resident_mb;
  int undos = 0, redos = 0, fault_resets = 0;
  const auto start = Clock::now();
  double next_sample = 0;
  std::size_t highest = 0, bytes_highest = 0;
  ProgressLine progress("soaking");
  while (seconds_since(start) < arguments.seconds) {
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
    const double t = seconds_since(start);
    if (!progress(t / arguments.seconds)) break;
    const sim::LiveState state = live.fetch_state();
    if (state.newest.faults & haptics::k_latched_faults) {
      live.reset_faults();
      ++fault_resets;
    }
    highest = std::max(highest, state.strokes);
    bytes_highest = std::max(bytes_highest, state.version->bytes());
    if (state.strokes >= 10 || (state.strokes > 3 && state.newest.has_contact && random() % 64 == 0)) {
      const std::size_t all = state.strokes >= 10 ? state.strokes : 1;
      for (std::size_t i = 0; i < all; ++i) live.undo(), ++undos;
      if (random() % 4 == 0) live.redo(), ++redos;
      burr.diameter = k_smallest + static_cast<double>(random() % 9) * 0.5;
      live.apply(burr);
    }
    if (t >= next_sample) {
      resident_mb.push_back(static_cast<double>(resident_bytes()) / 1e6);
      next_sample = t + std::max(1.0, arguments.seconds / 240);
    }
  }
  live.stop();
  const haptics::ServoReport servo = live.servo_report();
  if (Status error = recorder.value()->finish(live.engine())) return *error;
  const std::uint64_t hash = live.engine().version()->content_hash();

  // Replay.
  notice("replaying ...");
  ProgressLine again("replaying");
  auto session = workbench::open_session(record.file, "", terminal_listener());
  if (!session) return session.error();
  sim::Replay& replay = *session.value()->replay;
  for (std::uint64_t n = 0;; ++n) {
    if (n % 4096 == 0 &&
        !again(static_cast<double>(replay.next_tick()) / static_cast<double>(servo.ticks + 1)))
      return interrupted("the replay");
    const Result<bool> stepped = replay.step();
    if (!stepped) return stepped.error();
    if (!stepped.value()) break;
  }
  const bool is_same = !replay.mismatch() && replay.engine().version()->content_hash() == hash;
  const auto file_bytes = static_cast<std::size_t>(std::filesystem::file_size(record.file));
  if (arguments.session.empty() && is_same) {
    std::error_code ignored;
    std::filesystem::remove(record.file, ignored);
  }
  // Memory is flat if its mean in the last quarter of the run exceeds the mean in the second quarter by less
  // than 16 MB + 5 % of the latter. This tolerance covers memory that the allocator keeps.
  const auto mean = [&resident_mb](double from, double to) {
    double sum = 0;
    int count = 0;
    for (std::size_t i = static_cast<std::size_t>(from * static_cast<double>(resident_mb.size()));
         i < static_cast<std::size_t>(to * static_cast<double>(resident_mb.size())); ++i)
      sum += resident_mb[i], ++count;
    return count ? sum / count : 0;
  };
  const double early = mean(0.25, 0.5), late = mean(0.75, 1);
  const bool is_flat = late - early < 16 + 0.05 * early;
  const bool has_worked = replay.counts().versions > 0 && undos > 0;

  Outcome outcome("soak", is_same && is_flat && has_worked ? exit_done : exit_check_failed);
  Json& json = outcome.json;
  json["source"] = name_in_report(source);
  json["seconds"] = seconds_since(start);
  json["ticks"] = servo.ticks;
  json["dropped_ticks"] = servo.dropped;
  json["fault_resets"] = fault_resets;
  json["undos"] = undos;
  json["redos"] = redos;
  json["commands_replayed"] = replay.counts().commands;
  json["versions"] = replay.counts().versions;
  json["most_strokes"] = highest;
  json["most_version_bytes"] = bytes_highest;
  json["session_bytes"] = file_bytes;
  json["is_same"] = is_same;
  json["is_flat"] = is_flat;
  json["has_worked"] = has_worked;
  json["resident_mb"] = {{"second_quarter", early}, {"last_quarter", late}, {"samples", resident_mb}};
  json["servo"] = {{"step_p50_us", servo.step_p50_us},
                   {"step_p99_us", servo.step_p99_us},
                   {"late_p99_us", servo.late_p99_us},
                   {"overruns", servo.overruns},
                   {"faults", servo.faults}};
  json["content_hash"] = hash_text(hash);
  outcome.print(std::string("{ticks} ticks, {versions} versions, {undos} undos, {redos} redos; memory "
                            "{resident_mb/second_quarter:.0f} MB in the second quarter, "
                            "{resident_mb/last_quarter:.0f} MB in the last: ") +
                (is_flat ? "flat" : "NOT flat"));
  outcome.print(std::string("replayed from {session_bytes} bytes: ") +
                (is_same ? "the same to the bit" : "NOT the same"));
  if (!has_worked) outcome.print("no cut was undone: the soak is inconclusive");
  if (replay.mismatch())
    outcome.print("  {what} at tick {tick}",
                  {{"what", replay.mismatch()->what}, {"tick", replay.mismatch()->tick}});
  return outcome;
}

Run build(Options& options) {
  auto a = std::make_shared<SoakArguments>();
  add_source(options, a->source);
  add_shape(options, a->shape);
  options.add("--seconds", a->seconds, "Duration").shows_default();
  options.add("--rate", a->rate, "Servo steps per second, 250 to 10000").shows_default().type("HZ");
  options.add("--seed", a->seed, "Seed of the hand's motion").shows_default();
  options
      .add("--record", a->session,
           "File for the session, which is kept (default: temporary, removed after an identical replay)")
      .type("FILE");
  return run_with(a, run_soak);
}

}  // namespace

const Command k_soak{
    "soak",
    "Drill, undo and redo live for a long time; check that memory does not grow and that a replay gives the same bits",
    "  trephine-bench soak --seconds 60\n  trephine-bench soak SCANS/HEAD --seconds 3600 --json", build};

}  // namespace trephine::bench
