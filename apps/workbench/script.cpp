#include "apps/workbench/script.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <span>
#include <thread>

#include "apps/workbench/text.h"
#include "modules/catalogue.h"
#include "volume/text.h"

namespace trephine::workbench {

using data_tools::Script;
using data_tools::ScriptCommand;
using data_tools::ScriptExpectation;
using data_tools::ScriptHand;
using data_tools::ScriptPicture;
using data_tools::ScriptPlace;
using glm::dvec3;
using volume::Error;
using volume::Result;
using volume::Status;

namespace {

std::string at_line(const std::string& where, int line) { return where + ", line " + std::to_string(line); }

/// A file as the script names it.
std::string seen_from(const std::string& folder, const std::string& file) {
  const std::filesystem::path path(file);
  return path.is_absolute() || folder.empty() ? file : (std::filesystem::path(folder) / path).string();
}

/// Path of a hand whose points are in the world.
Result<haptics::PosePath> path_of(const ScriptHand& hand, const std::string& folder,
                                  const std::string& where) {
  if (!hand.path.empty()) return open_path(seen_from(folder, hand.path));
  const glm::dquat turn = hand.shaft ? turn_of_shaft(*hand.shaft) : glm::dquat(1, 0, 0, 0);
  std::vector<haptics::PosePath::Sample> samples;
  for (const auto& [t, x, y, z, button, share] : hand.points)
    samples.push_back({t, {{x, y, z}, turn, button != 0 ? 1u : 0u}});
  return haptics::PosePath::from_samples(std::move(samples), at_line(where, hand.line));
}

/// The path from second 0 on, which is a script's beginning.
haptics::PosePath from_zero(const haptics::PosePath& path) {
  std::vector<haptics::PosePath::Sample> samples{{0, path.at(0)}};
  for (const haptics::PosePath::Sample& sample : path.samples())
    if (sample.t > 0) samples.push_back(sample);
  return haptics::PosePath::from_samples(std::move(samples), "").value();
}

}  // namespace

namespace {

/// The command's words with places in them: `{site}` is where that is, `{site 5,0,2}` so many mm to its
/// right, upward and over it. Error names what is no place.
Result<std::string> placed_words(const ScriptCommand& said, std::span<const Place> places) {
  if (places.empty()) return said.words;
  std::string words;
  for (std::size_t at = 0; at < said.words.size();) {
    const std::size_t open = said.words.find('{', at), close = said.words.find('}', open);
    if (open == std::string::npos || close == std::string::npos) return words.append(said.words, at);
    words.append(said.words, at, open - at);
    const std::string inside = said.words.substr(open + 1, close - open - 1);
    // A name may have spaces; behind the last of them may be an offset.
    const auto named = [&](const std::string& name) {
      return std::find_if(places.begin(), places.end(), [&](const Place& one) { return one.name == name; });
    };
    auto place = named(inside);
    const std::size_t space = place == places.end() ? inside.rfind(' ') : std::string::npos;
    if (space != std::string::npos) place = named(inside.substr(0, space));
    dvec3 beside(0);
    char extra = 0;
    const bool is_read =
        space == std::string::npos ||
        std::sscanf(inside.c_str() + space, "%lf,%lf,%lf%c", &beside.x, &beside.y, &beside.z, &extra) == 3;
    if (place == places.end() || !is_read)
      return Error{"the words name no place", "with", "{" + inside + "}",
                   "{NAME} of the script's places, or {NAME X,Y,Z}", ""};
    const dvec3 p = place->at(beside);
    words.append(volume::text_of(p.x)).append(",").append(volume::text_of(p.y)).append(",");
    words.append(volume::text_of(p.z));
    at = close + 1;
  }
  return words;
}

Result<sim::Command> command_of(const ScriptCommand& said, std::span<const Place> places,
                                const std::string& where) {
  Result<std::string> words = placed_words(said, places);
  Result<sim::Command> command = sim::Command();
  if (words)
    command = modules::catalogue().command(said.name, words.value(), said.hand);
  else
    command = words.error();
  Status error = command ? std::nullopt : Status(command.error());
  if (!error && !said.is_refused) error = command.value().what.check();
  if (!error) return command;
  error->where = at_line(where, said.line) + (error->where.empty() ? "" : ": " + error->where);
  return *error;
}

}  // namespace

std::string scan_of(const Script& script, const std::string& folder) {
  return is_builtin(script.scan) ? script.scan : seen_from(folder, script.scan);
}

std::vector<std::string> files_of(const Script& script, const std::string& folder) {
  std::vector<std::string> files;
  if (!is_builtin(script.scan)) files.push_back(scan_of(script, folder));
  for (const ScriptHand& hand : script.hands)
    if (!hand.path.empty()) files.push_back(seen_from(folder, hand.path));
  for (const data_tools::ScriptModel& model : script.models)
    if (!model.file.empty()) files.push_back(seen_from(folder, model.file));
  return files;
}

Result<std::unique_ptr<ScriptRun>> ScriptRun::open(const Script& script, const std::string& folder,
                                                   const std::string& where, const Listener& listener) {
  OperationChoice choice;
  choice.shape = {script.iso, script.window, script.label, script.is_auto, script.is_largest};
  choice.rate_hz = script.rate_hz;
  choice.material.static_friction = script.static_friction;
  choice.material.dynamic_friction = script.dynamic_friction;
  choice.smallest_burr = script.smallest_burr;
  for (const data_tools::ScriptModel& model : script.models) {
    choice.models.push_back({model.file.empty() ? "" : seen_from(folder, model.file), 1, "", model.at,
                             model.screw, model.is_depth, model.beat, model.is_repeating});
    choice.models.back().rate = model.rate;
  }
  choice.hands.clear();
  if (Status error = check(choice)) {
    error->where = where + ": " + error->where;
    return *error;
  }
  std::vector<haptics::PosePath> paths;
  for (const ScriptHand& hand : script.hands) {
    sim::HandSpec& made = choice.hands.emplace_back();
    made.instrument = hand.instrument;
    made.parameters = hand.parameters;
    if (!hand.method.empty()) made.method = hand.method;
    made.tool_radius = hand.radius;
    made.effects = hand.effects;
    OperationChoice alone = choice;
    alone.hands = {made};
    Status error = check(alone);
    if (!error) {  // where a place is in the world is not known yet; its times are
      Result<haptics::PosePath> path = path_of(hand, folder, where);
      if (!path) return path.error();
      paths.push_back(std::move(path).value());
      continue;
    }
    error->where = at_line(where, hand.line) + ": " + error->where;
    return *error;
  }
  // Whether they can be understood is known before the scan is; where places are is not.
  std::vector<Place> unfound;
  for (const ScriptPlace& place : script.places) unfound.push_back({place.name});
  std::vector<sim::Command> commands;
  for (const ScriptCommand& said : script.commands) {
    Result<sim::Command> command = command_of(said, unfound, where);
    if (!command) return command.error();
    commands.push_back(std::move(command).value());
  }
  SourceChoice source(scan_of(script, folder));
  source.takes_plan = script.takes_plan;
  if (script.takes_plan && !is_builtin(script.scan))
    return Error{"only what is built in brings a plan of its own", where + ": plan", script.scan,
                 "scan = \"head\" or \"spine\"", "delete plan = true; a case folder has its plan anyway"};
  Result<Operation> operation = open_operation(source, choice, listener);
  if (!operation) {
    Error error = operation.error();
    error.where = where + (error.where.empty() ? "" : ": " + error.where);
    return error;
  }
  std::unique_ptr<ScriptRun> made(new ScriptRun(script, std::move(operation).value()));
  made->paths_ = std::move(paths);
  for (std::size_t i = 0; i < commands.size(); ++i)
    made->told_.push_back({&made->script_.commands[i], std::move(commands[i])});
  if (Status error = made->find_places(where)) return *error;
  for (Told& told : made->told_) {
    Result<sim::Command> command = command_of(*told.from, made->places_, where);
    if (!command) return command.error();
    told.command = std::move(command).value();
  }

  if (Status error = check_names(made->script_, made->places_, made->operation_.engine(), where))
    return *error;
  for (const haptics::PosePath& path : made->paths_)
    made->duration_ = std::max(made->duration_, path.end_time());
  for (const ScriptCommand& said : script.commands) made->duration_ = std::max(made->duration_, said.at);
  for (const ScriptExpectation& request : script.expectations)
    made->duration_ = std::max(made->duration_, request.at.value_or(0));
  for (const ScriptPicture& picture : script.pictures)
    made->duration_ = std::max(made->duration_, picture.at.value_or(0));
  return made;
}

Status ScriptRun::find_places(const std::string& where) {
  if (script_.places.empty()) return std::nullopt;
  const haptics::TouchScene& scene = *operation_.scene();
  const volume::Version untouched(scene.base);
  for (const ScriptPlace& request : script_.places) {
    Result<Place> place = find_place(request, scene, untouched);
    if (!place) {
      Error error = place.error();
      error.where = at_line(where, request.line) + ": " + error.where;
      return error;
    }
    places_.push_back(std::move(place).value());
  }
  for (std::size_t h = 0; h < paths_.size(); ++h)
    for (const Place& place : places_)
      if (place.name == script_.hands[h].place) {
        Result<haptics::PosePath> path = haptics::PosePath::from_samples(
            samples_at(place, script_.hands[h], scene, untouched), at_line(where, script_.hands[h].line));
        if (!path) return path.error();
        paths_[h] = std::move(path).value();
      }
  return std::nullopt;
}

std::vector<std::unique_ptr<haptics::Device>> ScriptRun::devices() const {
  std::vector<std::unique_ptr<haptics::Device>> all;
  for (std::size_t h = 0; h < paths_.size(); ++h) {
    haptics::HandModel hand;
    hand.stiffness = script_.hands[h].stiffness.value_or(0);
    if (script_.hands[h].stiffness)
      all.push_back(std::make_unique<haptics::VirtualDevice>(from_zero(paths_[h]), hand));
    else
      all.push_back(std::make_unique<haptics::PlaybackDevice>(from_zero(paths_[h])));
  }
  return all;
}

Result<ScriptReport> ScriptRun::play(sim::SessionWriter* recorder, PictureTaker take_picture,
                                     const Listener& listener) {
  sim::Lockstep run(operation_.engine(), operation_.spec.force, script_.rate_hz, recorder);
  if (script_.free_pieces) run.watch_pieces(*script_.free_pieces);
  ScriptWatch watch(script_, places_, duration_, std::move(take_picture));
  const auto ticks = static_cast<std::uint64_t>(std::llround(duration_ * script_.rate_hz)) + 1;
  const auto hands = devices();
  for (const auto& hand : hands) (void)hand->open();  // these always can
  std::size_t next_told = 0;
  volume::VoxelBox changed = sim::k_no_voxels;
  const auto command_until = [&](double until, double t) {
    for (; next_told < told_.size() && told_[next_told].from->at <= until; ++next_told) {
      const sim::Outcome outcome = run.apply_whole(told_[next_told].command);
      changed = sim::united(changed, outcome.box);
      watch.record_command(*told_[next_told].from, t, outcome.refused);
    }
  };
  std::vector<haptics::Pose> poses(paths_.size());
  const auto progress = listener.progress("playing");
  const auto leave = [&](const Error& error) {
    if (recorder) (void)recorder->finish(run.engine());
    return error;
  };
  for (std::uint64_t tick = 0; tick < ticks; ++tick) {
    if (tick % 256 == 0 && !progress(static_cast<double>(tick) / static_cast<double>(ticks)))
      return leave({"the script was interrupted", "", "", "", "", volume::ErrorKind::interrupted});
    const double t = static_cast<double>(tick) / script_.rate_hz;
    command_until(t, t);
    for (std::size_t h = 0; h < hands.size(); ++h) hands[h]->read(t, poses[h]);
    const auto records = run.step(poses);
    for (std::size_t h = 0; h < hands.size(); ++h)
      hands[h]->write({records[h].force_world, records[h].torque_world});
    changed = sim::united(changed, run.last_outcome().box);
    if (Status error = watch.tick(t, records, run.engine(), changed)) return leave(*error);
    changed = sim::k_no_voxels;
  }
  command_until(duration_, duration_);
  Result<ScriptReport> report = watch.finish(run.engine());
  if (!report) return leave(report.error());
  if (recorder) report.value().recording = recorder->finish(run.engine());
  return report;
}

Result<ScriptRun::Live> ScriptRun::play_live(sim::SessionWriter& recorder, const Listener& listener) {
  const auto hands = devices();
  std::vector<haptics::Device*> borrowed;
  for (const auto& hand : hands) borrowed.push_back(hand.get());
  sim::LiveSession live(borrowed, operation_.engine(), operation_.servo(), &recorder);
  Live result;
  if (script_.free_pieces) live.watch_pieces(*script_.free_pieces);
  if (Status error = live.start()) return *error;
  const auto progress = listener.progress("playing live");
  // A command that takes longer than its moment moves the next ones, so that all stays in order.
  const auto due = [&](double at) {
    if (result.told.empty()) return at;
    return std::max(at, result.told.back().done_at + at - told_[result.told.size() - 1].from->at);
  };
  Status broken;
  for (;;) {
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
    const sim::LiveState state = live.fetch_state();
    // A machine that was busy elsewhere for a tenth of a second takes the force away; no person's hand is on
    // this stylus.
    if (state.newest.faults & haptics::fault_stale_scene) live.reset_faults(), ++result.stalls;
    const double t = state.newest.t;
    while (result.told.size() < told_.size() && due(told_[result.told.size()].from->at) <= t) {
      live.apply(told_[result.told.size()].command);
      live.snapshot().wait();  // until it was carried out
      sim::LiveState after = live.fetch_state();
      Live::Told told{after.refused, 0};
      // A job that it began is done before anything else, as without threads.
      while (after.pending_jobs > 0 && progress(t / duration_)) {
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
        after = live.fetch_state();
      }
      told.done_at = after.newest.t + 0.5 / script_.rate_hz;  // the tick after that one knows it
      result.told.push_back(told);
    }
    if (!progress(t / duration_))
      broken = Error{"the script was interrupted", "", "", "", "", volume::ErrorKind::interrupted};
    const bool is_over = t >= due(duration_) && result.told.size() == told_.size();
    // Pieces that the last stroke freed still come off.
    const bool is_working = script_.free_pieces && (state.is_asking_for_pieces || state.pending_jobs > 0);
    if (broken || (is_over && !is_working)) break;
  }
  live.stop();
  result.servo = live.servo_report();
  const Status finished = recorder.finish(live.engine());
  if (broken) return *broken;
  if (finished)
    return Error{"what was played live cannot be checked: its recording was not written whole",
                 "recording",
                 finished->found,
                 "room for it",
                 "make room, or play it without a servo's thread",
                 finished->kind};
  return result;
}

Result<ScriptReport> ScriptRun::watch(const Live& live, sim::Replay& recorded, PictureTaker take_picture,
                                      const Listener& listener) const {
  ScriptWatch watch(script_, places_, duration_, std::move(take_picture));
  for (std::size_t i = 0; i < live.told.size(); ++i) {
    watch.record_command(*told_[i].from, live.told[i].done_at, live.told[i].refused);
    watch.wait_for(told_[i].from->at, live.told[i].done_at);
  }
  std::vector<haptics::ServoRecord> records(paths_.size());
  volume::VoxelBox changed = sim::k_no_voxels;
  const auto progress = listener.progress("looking at it");
  for (std::uint64_t count = 0;; ++count) {
    const Result<bool> stepped = recorded.step();
    if (!stepped) return stepped.error();
    if (!stepped.value()) break;
    const haptics::ServoRecord& record = recorded.record();
    records[record.hand] = record;
    changed = sim::united(changed, recorded.take_changed());
    if (record.hand + 1u < records.size()) continue;
    if (count % 256 == 0 && !progress(record.t / duration_))
      return Error{"the script was interrupted", "", "", "", "", volume::ErrorKind::interrupted};
    if (Status error = watch.tick(record.t, records, recorded.engine(), changed)) return *error;
    changed = sim::k_no_voxels;
  }
  return watch.finish(recorded.engine());
}

}  // namespace trephine::workbench
