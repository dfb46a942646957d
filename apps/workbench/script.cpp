#include "apps/workbench/script.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <span>
#include <thread>

#include "apps/workbench/text.h"
#include "data-tools/cases/procedure_file.h"
#include "modules/catalogue.h"
#include "volume/base/text.h"

namespace trephine::workbench {

using data_tools::Script;
using data_tools::ScriptCommand;
using data_tools::ScriptExpectation;
using data_tools::ScriptHand;
using data_tools::ScriptPicture;
using data_tools::ScriptPlace;
using glm::dvec3;

namespace {

std::string at_line(const std::string& where, int line) { return where + ", line " + std::to_string(line); }

/// Returns the path of a file that a script names.
std::string resolve_path(const std::string& folder, const std::string& file) {
  const std::filesystem::path path(file);
  return path.is_absolute() || folder.empty() ? file : (std::filesystem::path(folder) / path).string();
}

/// Returns the path of a hand whose points are in the world.
Result<haptics::PosePath> path_of(const ScriptHand& hand, const std::string& folder,
                                  const std::string& where) {
  if (!hand.path.empty()) return open_path(resolve_path(folder, hand.path));
  const glm::dquat turn = hand.shaft ? turn_of_shaft(*hand.shaft) : glm::dquat(1, 0, 0, 0);
  std::vector<haptics::PosePath::Sample> samples;
  for (const auto& [t, x, y, z, button, share] : hand.points)
    samples.push_back({t, {{x, y, z}, turn, button != 0 ? 1u : 0u}});
  return haptics::PosePath::from_samples(std::move(samples), at_line(where, hand.line));
}

/// Returns the part of the path from 0 s on, the start of the script.
haptics::PosePath from_zero(const haptics::PosePath& path) {
  std::vector<haptics::PosePath::Sample> samples{{0, path.at(0)}};
  for (const haptics::PosePath::Sample& sample : path.samples())
    if (sample.t > 0) samples.push_back(sample);
  return haptics::PosePath::from_samples(std::move(samples), "").value();
}

}  // namespace

namespace {

Error unknown_place(const std::string& found, std::span<const Place> places) {
  std::string known;
  for (const Place& place : places) known.append(known.empty() ? "{" : ", {").append(place.name).append("}");
  return {.what = "unknown place, or its offset is not X,Y,Z",
          .where = "with",
          .found = "{" + found + "}",
          .expected = known + ", with an offset {NAME X,Y,Z}",
          .remedy = "correct the name, or add it to [[places]]"};
}

/// Replaces places in the words of a command by world coordinates. Here `{site}` is the position of a place,
/// and `{site 5,0,2}` the position 5 mm to the right of it, 0 mm upward and 2 mm outward. The error names an
/// unknown place.
Result<std::string> words_with_positions(const ScriptCommand& command, std::span<const Place> places) {
  if (places.empty()) return command.words;
  std::string words;
  for (std::size_t at = 0; at < command.words.size();) {
    const std::size_t open = command.words.find('{', at), close = command.words.find('}', open);
    if (open == std::string::npos || close == std::string::npos) return words.append(command.words, at);
    words.append(command.words, at, open - at);
    const std::string inside = command.words.substr(open + 1, close - open - 1);
    // A name may contain spaces; an offset may follow the last one.
    const auto find_by_name = [&](const std::string& name) {
      return std::find_if(places.begin(), places.end(), [&](const Place& one) { return one.name == name; });
    };
    auto place = find_by_name(inside);
    const std::size_t space = place == places.end() ? inside.rfind(' ') : std::string::npos;
    if (space != std::string::npos) place = find_by_name(inside.substr(0, space));
    dvec3 offset(0);
    char extra = 0;
    const bool is_read =
        space == std::string::npos ||
        (std::sscanf(inside.c_str() + space, "%lf,%lf,%lf%c", &offset.x, &offset.y, &offset.z, &extra) == 3 &&
         std::max({std::abs(offset.x), std::abs(offset.y), std::abs(offset.z)}) < 1e6);
    if (place == places.end() || !is_read) return unknown_place(inside, places);
    const dvec3 p = place->at(offset);
    words.append(text_of(p.x)).append(",").append(text_of(p.y)).append(",");
    words.append(text_of(p.z));
    at = close + 1;
  }
  return words;
}

Result<sim::Command> command_of(const ScriptCommand& request, std::span<const Place> places,
                                const std::string& where) {
  Result<std::string> words = words_with_positions(request, places);
  Result<sim::Command> command = sim::Command();
  if (words)
    command = modules::catalogue().command(request.name, words.value(), request.hand);
  else
    command = words.error();
  Status error = command ? std::nullopt : Status(command.error());
  if (!error && !request.refusal) error = command.value().request.check();
  if (!error) return command;
  // The positions of places may not be known at this time. The error quotes the words of the script instead.
  if (words && request.words.find('{') != std::string::npos) error->found = request.words;
  error->where = at_line(where, request.line) + (error->where.empty() ? "" : ": " + error->where);
  return *error;
}

}  // namespace

std::string scan_of(const Script& script, const std::string& folder) {
  return is_builtin(script.scan) ? script.scan : resolve_path(folder, script.scan);
}

std::string procedure_of(const Script& script, const std::string& folder) {
  return data_tools::is_procedure_path(script.procedure) ? resolve_path(folder, script.procedure)
                                                         : script.procedure;
}

std::vector<std::string> files_of(const Script& script, const std::string& folder) {
  std::vector<std::string> files;
  if (data_tools::is_procedure_path(script.procedure)) files.push_back(procedure_of(script, folder));
  if (!is_builtin(script.scan)) files.push_back(scan_of(script, folder));
  for (const ScriptHand& hand : script.hands)
    for (const std::string& file : {hand.path, hand.tool})
      if (!file.empty()) files.push_back(resolve_path(folder, file));
  for (const data_tools::ScriptVolume& volume : script.volumes)
    if (!is_builtin(volume.file)) files.push_back(resolve_path(folder, volume.file));
  for (const data_tools::ScriptModel& model : script.models)
    if (!model.file.empty()) files.push_back(resolve_path(folder, model.file));
  return files;
}

Result<std::unique_ptr<ScriptRun>> ScriptRun::open(const Script& script, const std::string& folder,
                                                   const std::string& where, const Listener& listener,
                                                   const std::optional<Performance>& performance) {
  OperationChoice choice;
  choice.shape = {script.iso, script.window, script.label, script.is_auto, script.is_largest};
  choice.rate_hz = script.rate_hz;
  choice.material.static_friction = script.static_friction;
  choice.material.dynamic_friction = script.dynamic_friction;
  choice.smallest_burr = script.smallest_burr;
  choice.procedure = procedure_of(script, folder);
  for (const data_tools::ScriptVolume& volume : script.volumes)
    choice.volumes.push_back({is_builtin(volume.file) ? volume.file : resolve_path(folder, volume.file),
                              parse_shape(volume.shape), volume.name, volume.matter});
  for (const data_tools::ScriptModel& model : script.models) {
    ModelChoice& one = choice.models.emplace_back();
    if (!model.file.empty()) one.file = resolve_path(folder, model.file);
    one.at_world = model.at, one.screw = model.screw;
    one.matter = model.matter, one.is_forbidden = model.is_forbidden;
    one.is_depth = model.is_depth, one.beat = model.beat, one.is_repeating = model.is_repeating;
    one.rate = model.rate;
  }
  choice.hands.clear();
  if (Status error = check(choice)) {
    error->where = where + ": " + error->where;
    return *error;
  }
  std::vector<haptics::PosePath> paths;
  for (const ScriptHand& hand : script.hands) {
    sim::HandSpec& output = choice.hands.emplace_back();
    output.instrument = hand.instrument;
    output.parameters = hand.parameters;
    if (!hand.method.empty()) output.method = hand.method;
    output.tool = std::make_shared<const haptics::ToolShape>(hand.radius);
    output.effects = hand.effects;
    OperationChoice hand_choice = choice;
    hand_choice.hands = {output};
    if (!hand.tool.empty()) {
      ToolModelChoice tool{choice.hands.size() - 1, {}, hand.tool_spacing};
      tool.model.file = resolve_path(folder, hand.tool);
      hand_choice.tools = {tool};
      choice.tools.push_back(std::move(tool));
    }
    Status error = check(hand_choice);
    if (!error) {  // for a hand at a place only the times of this path are valid; find_places() replaces it
      Result<haptics::PosePath> path = path_of(hand, folder, where);
      if (!path) return path.error();
      paths.push_back(std::move(path).value());
      continue;
    }
    error->where = at_line(where, hand.line) + ": " + error->where;
    return *error;
  }
  // Parses the commands before the scan is read, to find errors early. The positions of places are not known,
  // and are replaced by default values.
  std::vector<Place> unresolved_places;
  for (const ScriptPlace& place : script.places) unresolved_places.push_back({place.name});
  std::vector<sim::Command> commands;
  for (const ScriptCommand& request : script.commands) {
    Result<sim::Command> command = command_of(request, unresolved_places, where);
    if (!command) return command.error();
    commands.push_back(std::move(command).value());
  }
  SourceChoice source(scan_of(script, folder));
  source.uses_plan = script.uses_plan;
  if (script.uses_plan && !is_builtin(script.scan) && std::filesystem::exists(source.path))
    return Error{.what = "only built-in phantoms have a built-in plan",
                 .where = where + ": plan",
                 .found = script.scan,
                 .expected = "scan = \"head\" or \"spine\"",
                 .remedy = "delete plan = true; a case folder has its plan anyway"};
  Result<Operation> operation = open_operation(source, choice, listener);
  if (!operation) {
    Error error = operation.error();
    error.where = where + (error.where.empty() ? "" : ": " + error.where);
    return error;
  }
  std::unique_ptr<ScriptRun> output(new ScriptRun(script, std::move(operation).value()));
  output->paths_ = std::move(paths);
  for (std::size_t i = 0; i < commands.size(); ++i)
    output->commands_.push_back({&output->script_.commands[i], std::move(commands[i])});
  std::optional<Performer> performer;
  if (performance) performer.emplace(performance->skill, performance->seed, output->planned_duration());
  if (Status error = output->find_places(where, performer ? &*performer : nullptr)) return *error;
  for (TimedCommand& timed : output->commands_) {
    Result<sim::Command> command = command_of(*timed.from, output->places_, where);
    if (!command) return command.error();
    timed.command = std::move(command).value();
  }

  if (Status error = check_names(output->script_, output->places_, output->operation_.engine(), where))
    return *error;
  output->duration_ = output->planned_duration();
  if (performer) output->perform(*performer);
  return output;
}

/// Returns the time of the last motion, command, expectation or picture, s.
double ScriptRun::planned_duration() const {
  double duration = 0;
  for (const haptics::PosePath& path : paths_) duration = std::max(duration, path.end_time());
  for (const ScriptCommand& request : script_.commands) duration = std::max(duration, request.at);
  for (const ScriptExpectation& request : script_.expectations)
    duration = std::max(duration, request.at.value_or(0));
  for (const ScriptPicture& picture : script_.pictures) duration = std::max(duration, picture.at.value_or(0));
  return duration;
}

/// Replaces the planned motions and times by those of the performer.
void ScriptRun::perform(const Performer& performer) {
  for (std::size_t h = 0; h < paths_.size(); ++h) paths_[h] = performer.perform(paths_[h], h);
  for (ScriptCommand& request : script_.commands) request.at = performer.time_of(request.at);
  for (ScriptExpectation& request : script_.expectations)
    if (request.at) request.at = performer.time_of(*request.at);
  for (ScriptPicture& picture : script_.pictures)
    if (picture.at) picture.at = performer.time_of(*picture.at);
  duration_ = performer.time_of(duration_);
}

Result<Place> ScriptRun::find_trajectory_place(const ScriptPlace& request) const {
  std::string known;
  for (const volume::PlannedTrajectory& trajectory : operation_.spec.plan.trajectories) {
    if (trajectory.name == request.trajectory)
      return place_of(trajectory, request, *operation_.scene(), volume::Version(operation_.scene()->base));
    known += (known.empty() ? "" : ", ") + trajectory.name;
  }
  return Error{.what = "unknown trajectory",
               .where = "place " + request.name,
               .found = request.trajectory,
               .expected = known.empty() ? "a scan with a plan" : known};
}

/// Finds the places, and sets the paths that are relative to them. The performer, if any, displaces the
/// places.
Status ScriptRun::find_places(const std::string& where, const Performer* performer) {
  if (script_.places.empty()) return std::nullopt;
  const haptics::TouchScene& scene = *operation_.scene();
  const volume::Version uncut(scene.base);
  for (const ScriptPlace& request : script_.places) {
    if (request.body > 0) {
      places_.push_back({.name = request.name, .body = request.body});
      continue;
    }
    Result<Place> place =
        request.trajectory.empty() ? find_place(request, scene, uncut) : find_trajectory_place(request);
    if (!place) {
      Error error = place.error();
      error.where = at_line(where, request.line) + ": " + error.where;
      return error;
    }
    places_.push_back(std::move(place).value());
    if (performer) performer->displace(places_.back());
  }
  for (std::size_t h = 0; h < paths_.size(); ++h)
    for (const Place& place : places_)
      if (place.name == script_.hands[h].place) {
        Result<haptics::PosePath> path = haptics::PosePath::from_samples(
            samples_at(place, script_.hands[h], scene, uncut), at_line(where, script_.hands[h].line));
        if (!path) return path.error();
        paths_[h] = std::move(path).value();
      }
  return std::nullopt;
}

bool ScriptRun::has_places_on_bodies() const noexcept {
  return std::any_of(places_.begin(), places_.end(), [](const Place& place) { return place.body > 0; });
}

/// Returns a command in which places on bodies have the positions that the bodies have in `state`.
Result<sim::Command> ScriptRun::command_at(const TimedCommand& timed,
                                           const sim::OperationState& state) const {
  const Result<std::vector<Place>> places = places_in(state, places_, timed.from->words);
  if (!places) return places.error();
  return command_of(*timed.from, places.value(), "script");
}

std::vector<std::unique_ptr<haptics::Device>> ScriptRun::devices() const {
  std::vector<std::unique_ptr<haptics::Device>> result;
  for (std::size_t h = 0; h < paths_.size(); ++h) {
    haptics::HandModel hand;
    hand.stiffness = script_.hands[h].stiffness.value_or(0);
    if (script_.hands[h].stiffness)
      result.push_back(std::make_unique<haptics::VirtualDevice>(from_zero(paths_[h]), hand));
    else
      result.push_back(std::make_unique<haptics::PlaybackDevice>(from_zero(paths_[h])));
  }
  return result;
}

Result<ScriptReport> ScriptRun::play(sim::SessionWriter* recorder, PictureTaker take_picture,
                                     const Listener& listener) {
  sim::Lockstep run(operation_.engine(), operation_.spec.force, script_.rate_hz, recorder);
  if (script_.free_pieces) run.watch_pieces(*script_.free_pieces);
  ScriptWatch watch(script_, places_, duration_, std::move(take_picture));
  const auto ticks = static_cast<std::uint64_t>(std::llround(duration_ * script_.rate_hz)) + 1;
  const auto hands = devices();
  for (const auto& hand : hands) (void)hand->open();  // these devices cannot fail
  const bool has_bodies = has_places_on_bodies();
  std::size_t next_command = 0;
  volume::VoxelBox changed = sim::k_no_voxels;
  const auto command_until = [&](double until, double t) {
    for (; next_command < commands_.size() && commands_[next_command].from->at <= until; ++next_command) {
      const TimedCommand& timed = commands_[next_command];
      const Result<sim::Command> command =
          has_bodies ? command_at(timed, run.engine().state()) : timed.command;
      if (!command) {
        watch.record_command(*timed.from, t, command.error());
        continue;
      }
      const sim::Outcome outcome = run.apply_and_finish(command.value());
      changed = sim::union_of(changed, outcome.box);
      watch.record_command(*timed.from, t, outcome.refused ? outcome.refused : outcome.failed);
    }
  };
  std::vector<haptics::Pose> poses(paths_.size());
  const auto progress = listener.progress("playing");
  const auto finish_with_error = [&](const Error& error) {
    if (recorder) (void)recorder->finish(run.engine());
    return error;
  };
  for (std::uint64_t tick = 0; tick < ticks; ++tick) {
    if (tick % 256 == 0 && !progress(static_cast<double>(tick) / static_cast<double>(ticks)))
      return finish_with_error({"the script was interrupted", "", "", "", "", ErrorKind::interrupted});
    const double t = static_cast<double>(tick) / script_.rate_hz;
    command_until(t, t);
    for (std::size_t h = 0; h < hands.size(); ++h) hands[h]->read(t, poses[h]);
    const auto records = run.step(poses);
    for (std::size_t h = 0; h < hands.size(); ++h)
      hands[h]->write({records[h].force_world, records[h].torque_world});
    changed = sim::union_of(changed, run.last_outcome().box);
    if (Status error = watch.tick(t, records, run.engine(), changed)) return finish_with_error(*error);
    changed = sim::k_no_voxels;
  }
  command_until(duration_, duration_);
  Result<ScriptReport> report = watch.finish(run.engine());
  if (!report) return finish_with_error(report.error());
  if (recorder) report.value().recording_error = recorder->finish(run.engine());
  return report;
}

Result<ScriptRun::Live> ScriptRun::play_live(sim::SessionWriter& recorder, const Listener& listener) {
  const auto hands = devices();
  std::vector<haptics::Device*> borrowed;
  for (const auto& hand : hands) borrowed.push_back(hand.get());
  sim::LiveSession live(borrowed, operation_.engine(), operation_.servo(), &recorder);
  Live result;
  const bool has_bodies = has_places_on_bodies();
  if (script_.free_pieces) live.watch_pieces(*script_.free_pieces);
  if (Status error = live.start()) return *error;
  const auto progress = listener.progress("playing live");
  // A slow command delays the following ones, so that all stay in order.
  const auto due = [&](double at) {
    if (result.results.empty()) return at;
    return std::max(at, result.results.back().done_at + at - commands_[result.results.size() - 1].from->at);
  };
  Status interruption;
  for (;;) {
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
    const sim::LiveState state = live.fetch_state();
    // If the machine is busy for a tenth of a second, the servo latches a fault and turns the force off. The
    // fault may be reset here, since no person holds this simulated stylus.
    if (state.newest.faults & haptics::fault_stale_scene) live.reset_faults(), ++result.stalls;
    const double t = state.newest.t;
    while (result.results.size() < commands_.size() && due(commands_[result.results.size()].from->at) <= t) {
      const TimedCommand& timed = commands_[result.results.size()];
      const Result<sim::Command> command =
          has_bodies ? command_at(timed, *live.snapshot().get()) : timed.command;
      if (!command) {
        result.results.push_back({command.error(), live.fetch_state().newest.t + 0.5 / script_.rate_hz});
        continue;
      }
      live.apply(command.value());
      live.snapshot().wait();  // until the command was applied
      sim::LiveState latest = live.fetch_state();
      Live::CommandResult command_result{latest.refused, 0};
      const auto record_failure = [&] {
        // Only failures of this command count: a search for free pieces may fail at the same time.
        if (latest.failed && latest.failed->where == timed.from->name) command_result.refused = latest.failed;
      };
      record_failure();
      // Waits for the job of the command, so that the job ends before the next command, as in play().
      while (latest.pending_jobs > 0 && progress(t / duration_)) {
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
        latest = live.fetch_state();
        record_failure();
      }
      // Half a tick is added because only the next tick includes the effect of the command.
      command_result.done_at = latest.newest.t + 0.5 / script_.rate_hz;
      result.results.push_back(command_result);
    }
    if (!progress(t / duration_))
      interruption = Error{.what = "the script was interrupted", .kind = ErrorKind::interrupted};
    const bool is_over = t >= due(duration_) && result.results.size() == commands_.size();
    // Waits for pieces that the last stroke has disconnected.
    const bool is_working = script_.free_pieces && (state.is_searching_pieces || state.pending_jobs > 0);
    if (interruption || (is_over && !is_working)) break;
  }
  live.stop();
  result.servo = live.servo_report();
  const Status finished = recorder.finish(live.engine());
  if (interruption) return *interruption;
  if (finished)
    return Error{.what = "the live run cannot be checked: its recording is incomplete",
                 .where = "recording",
                 .found = finished->found,
                 .expected = "enough free disk space",
                 .remedy = "free disk space, or play the script without a servo thread",
                 .kind = finished->kind};
  return result;
}

Result<ScriptReport> ScriptRun::watch(const Live& live, sim::Replay& recorded, PictureTaker take_picture,
                                      const Listener& listener) const {
  ScriptWatch watch(script_, places_, duration_, std::move(take_picture));
  for (std::size_t i = 0; i < live.results.size(); ++i) {
    watch.record_command(*commands_[i].from, live.results[i].done_at, live.results[i].refused);
    watch.wait_for(commands_[i].from->at, live.results[i].done_at);
  }
  std::vector<haptics::ServoRecord> records(paths_.size());
  volume::VoxelBox changed = sim::k_no_voxels;
  const auto progress = listener.progress("checking the recording");
  for (std::uint64_t count = 0;; ++count) {
    const Result<bool> stepped = recorded.step();
    if (!stepped) return stepped.error();
    if (!stepped.value()) break;
    const haptics::ServoRecord& record = recorded.record();
    records[record.hand] = record;
    changed = sim::union_of(changed, recorded.take_changed());
    if (record.hand + 1u < records.size()) continue;
    if (count % 256 == 0 && !progress(record.t / duration_))
      return Error{.what = "the script was interrupted", .kind = ErrorKind::interrupted};
    if (Status error = watch.tick(record.t, records, recorded.engine(), changed)) return *error;
    changed = sim::k_no_voxels;
  }
  return watch.finish(recorded.engine());
}

}  // namespace trephine::workbench
