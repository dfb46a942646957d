#include "apps/workbench/script.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <glm/geometric.hpp>

#include "apps/workbench/catalogue.h"
#include "apps/workbench/text.h"
#include "volume/text.h"

namespace trephine::workbench {

using data_tools::Script;
using data_tools::ScriptCommand;
using data_tools::ScriptExpectation;
using data_tools::ScriptHand;
using volume::Error;
using volume::Result;
using volume::Status;

namespace {

/// Measured of a hand or of all, by name; "events NAME" and "nearest_mm STRUCTURE" beside them.
constexpr const char* k_names[] = {"removed_mm3", "strokes", "bodies",  "force_n", "strongest_force_n",
                                   "contact",     "proxy_x", "proxy_y", "proxy_z"};
constexpr std::string_view k_events = "events ", k_nearest = "nearest_mm ";

std::string at_line(const std::string& where, int line) { return where + ", line " + std::to_string(line); }

/// A file as the script names it.
std::string seen_from(const std::string& folder, const std::string& file) {
  const std::filesystem::path path(file);
  return path.is_absolute() || folder.empty() ? file : (std::filesystem::path(folder) / path).string();
}

Result<haptics::PosePath> path_of(const ScriptHand& hand, const std::string& folder,
                                  const std::string& where) {
  if (!hand.path.empty()) return open_path(seen_from(folder, hand.path));
  std::vector<haptics::PosePath::Sample> samples;
  for (const auto& p : hand.points)
    samples.push_back({p[0], {{p[1], p[2], p[3]}, {1, 0, 0, 0}, p[4] != 0 ? 1u : 0u}});
  return haptics::PosePath::from_samples(std::move(samples), at_line(where, hand.line));
}

}  // namespace

bool may_be_told(const sim::ValueType& type) {
  for (const sim::ValueType* books : {&sim::value_type<sim::AdoptFields>(), &sim::value_type<sim::AdoptJob>(),
                                      &sim::value_type<sim::CancelJob>(), &sim::value_type<sim::Resume>()})
    if (&type == books) return false;
  return !catalogue().is_event(type);
}

namespace {

Result<sim::Command> command_of(const ScriptCommand& said, const std::string& where) {
  const sim::ValueType* type = catalogue().find(said.name);
  if (type == nullptr || !may_be_told(*type)) {
    std::string known;
    for (const sim::ValueType* one : catalogue().all())
      if (may_be_told(*one)) known.append(known.empty() ? "" : ", ").append(one->schema->name);
    return Error{"there is no such command", at_line(where, said.line), said.name, known,
                 "choose one of these"};
  }
  sim::Value what = sim::Value::of(*type);
  Status error = what.set(said.words);
  if (!error && !said.is_refused) error = what.check();
  if (!error) return sim::Command(std::move(what), static_cast<std::uint8_t>(said.hand));
  error->where = at_line(where, said.line) + ": " + error->where;
  return *error;
}

}  // namespace

std::vector<std::string> expectable() {
  std::vector<std::string> all(std::begin(k_names), std::end(k_names));
  all.push_back(std::string(k_events) + "NAME");
  all.push_back(std::string(k_nearest) + "STRUCTURE");
  return all;
}

std::vector<std::string> files_of(const Script& script, const std::string& folder) {
  std::vector<std::string> files;
  if (script.scan != "head") files.push_back(seen_from(folder, script.scan));
  for (const ScriptHand& hand : script.hands)
    if (!hand.path.empty()) files.push_back(seen_from(folder, hand.path));
  return files;
}

bool ScriptReport::is_met() const {
  return std::all_of(checks.begin(), checks.end(), [](const ScriptCheck& check) { return check.is_met; });
}

Result<std::unique_ptr<ScriptRun>> ScriptRun::open(const Script& script, const std::string& folder,
                                                   const std::string& where, const Listener& listener) {
  OperationChoice choice;
  choice.shape = {script.iso, script.window, script.label};
  choice.rate_hz = script.rate_hz;
  choice.smallest_burr = script.smallest_burr;
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
    if (!error) {
      Result<haptics::PosePath> path = path_of(hand, folder, where);
      if (!path) return path.error();
      paths.push_back(std::move(path).value());
      continue;
    }
    error->where = at_line(where, hand.line) + ": " + error->where;
    return *error;
  }
  std::vector<sim::Command> commands;
  for (const ScriptCommand& said : script.commands) {
    Result<sim::Command> command = command_of(said, where);
    if (!command) return command.error();
    commands.push_back(std::move(command).value());
  }
  const std::string scan = script.scan == "head" ? script.scan : seen_from(folder, script.scan);
  Result<Operation> operation = open_operation(scan, choice, listener);
  if (!operation) return operation.error();
  std::unique_ptr<ScriptRun> made(new ScriptRun(script, std::move(operation).value()));
  made->paths_ = std::move(paths);
  for (std::size_t i = 0; i < commands.size(); ++i)
    made->told_.push_back({&made->script_.commands[i], std::move(commands[i])});
  if (Status error = made->check_names(where)) return *error;
  return made;
}

Status ScriptRun::check_names(const std::string& where) const {
  const sim::Engine engine = operation_.engine();
  for (const ScriptExpectation& wish : script_.expectations) {
    const auto is_measure = [&](const sim::Measure& one) { return one.name == wish.what; };
    const std::vector<sim::Measure> measures = engine.measures();
    bool is_known = std::find(std::begin(k_names), std::end(k_names), wish.what) != std::end(k_names) ||
                    std::any_of(measures.begin(), measures.end(), is_measure);
    if (wish.what.starts_with(k_events)) {
      const sim::ValueType* type = catalogue().find(wish.what.substr(k_events.size()));
      is_known = type && catalogue().is_event(*type);
    }
    if (wish.what.starts_with(k_nearest))
      is_known = std::any_of(
          engine.forbidden().begin(), engine.forbidden().end(),
          [&](const auto& structure) { return structure->name() == wish.what.substr(k_nearest.size()); });
    if (is_known) continue;
    std::string known;
    for (const std::string& name : expectable()) known += (known.empty() ? "" : ", ") + name;
    for (const sim::Measure& one : measures) known += ", " + one.name;
    return Error{"nothing is measured by this name", at_line(where, wish.line), wish.what, known,
                 "choose one of these"};
  }
  return std::nullopt;
}

void ScriptRun::tell(const Told& told, double t, ScriptReport& report) {
  const sim::Outcome begun = run_->apply(told.command);
  const bool is_refused = begun.refused.has_value();
  // A job is done at once: nobody waits for it here.
  if (!is_refused && begun.job.value != 0) {
    const auto& pending = run_->engine().jobs();
    const bool is_pending = std::any_of(pending.begin(), pending.end(),
                                        [&](const sim::PendingJob& job) { return job.id == begun.job; });
    if (is_pending) run_->apply(run_->engine().finish_job(begun.job));
  }
  if (is_refused == told.from->is_refused && !is_refused) return;
  report.checks.push_back(
      {told.from->line, std::string(told.from->name) + (told.from->is_refused ? " is refused" : " is done"),
       t, is_refused == told.from->is_refused,
       is_refused ? begun.refused->what : std::string("it was done")});
}

std::optional<double> ScriptRun::value_of(const std::string& what, int hand,
                                          const ScriptReport& report) const {
  const sim::Engine& engine = run_->engine();
  const auto h = static_cast<std::size_t>(hand);
  const haptics::ServoRecord& record = run_->last_record(h);
  if (what == "removed_mm3") return engine.removed_mm3();
  if (what == "strokes") return static_cast<double>(engine.stroke_count());
  if (what == "bodies") return static_cast<double>(engine.now().world.bodies.size());
  if (what == "force_n") return glm::length(record.force_world);
  if (what == "strongest_force_n") return report.strongest_of[h];
  if (what == "contact") return record.has_contact;
  for (int axis = 0; axis < 3; ++axis)
    if (what == std::string("proxy_") + "xyz"[axis]) return record.proxy_world[axis];
  if (what.starts_with(k_events)) {
    double count = 0;
    const sim::Chronicle& all = engine.now().chronicle;
    for (std::size_t i = 0; i < all.size(); ++i)
      count += all[i].hand == hand && all[i].what.name() == what.substr(k_events.size());
    return count;
  }
  if (what.starts_with(k_nearest))
    for (std::size_t s = 0; s < engine.forbidden().size(); ++s)
      if (engine.forbidden()[s]->name() == what.substr(k_nearest.size())) return engine.watch(h, s).nearest;
  for (const sim::Measure& one : engine.measures())
    if (one.name == what) return one.value;
  return std::nullopt;
}

Result<ScriptReport> ScriptRun::play(sim::SessionWriter* recorder, const Listener& listener) {
  run_.emplace(operation_.engine(), operation_.spec.force, script_.rate_hz, recorder);
  double end = 0;
  for (const haptics::PosePath& path : paths_) end = std::max(end, path.end_time());
  for (const ScriptCommand& said : script_.commands) end = std::max(end, said.at);
  for (const ScriptExpectation& wish : script_.expectations) end = std::max(end, wish.at.value_or(0));
  const auto ticks = static_cast<std::uint64_t>(std::llround(end * script_.rate_hz)) + 1;

  std::vector<const ScriptExpectation*> wishes;
  for (const ScriptExpectation& wish : script_.expectations) wishes.push_back(&wish);
  std::stable_sort(wishes.begin(), wishes.end(), [end](const auto* a, const auto* b) {
    return a->at.value_or(2 * end) < b->at.value_or(2 * end);
  });
  ScriptReport report;
  report.strongest_of.resize(paths_.size());
  const auto check = [&](const ScriptExpectation& wish, double t) {
    const double value = value_of(wish.what, wish.hand, report).value_or(std::nan(""));
    std::string words = wish.what;
    if (wish.least) words = volume::text_of(*wish.least) + " <= " + words;
    if (wish.most) words += " <= " + volume::text_of(*wish.most);
    const bool is_met = value >= wish.least.value_or(value) && value <= wish.most.value_or(value);
    report.checks.push_back({wish.line, words, t, is_met, volume::text_of(value)});
  };

  std::size_t next_told = 0, next_wish = 0;
  std::vector<haptics::Pose> poses(paths_.size());
  const auto progress = listener.progress("playing");
  for (std::uint64_t tick = 0; tick < ticks; ++tick) {
    if (tick % 256 == 0 && !progress(static_cast<double>(tick) / static_cast<double>(ticks))) {
      if (recorder) (void)recorder->finish(run_->engine(), 0);
      return Error{"the script was interrupted", "", "", "", "", volume::ErrorKind::interrupted};
    }
    const double t = static_cast<double>(tick) / script_.rate_hz;
    for (; next_told < told_.size() && told_[next_told].from->at <= t; ++next_told)
      tell(told_[next_told], t, report);
    for (std::size_t h = 0; h < paths_.size(); ++h) poses[h] = paths_[h].at(t);
    for (const haptics::ServoRecord& record : run_->step(poses)) {
      const double force = glm::length(record.force_world);
      report.strongest_of[record.hand] = std::max(report.strongest_of[record.hand], force);
      report.strongest_force_n = std::max(report.strongest_force_n, force);
    }
    for (; next_wish < wishes.size() && wishes[next_wish]->at.value_or(2 * end) <= t; ++next_wish)
      check(*wishes[next_wish], t);
  }
  for (; next_told < told_.size(); ++next_told) tell(told_[next_told], end, report);
  for (; next_wish < wishes.size(); ++next_wish) check(*wishes[next_wish], end);
  report.ticks = ticks;
  report.seconds = end;
  std::stable_sort(report.checks.begin(), report.checks.end(),
                   [](const ScriptCheck& a, const ScriptCheck& b) { return a.line < b.line; });
  if (recorder) report.recording = recorder->finish(run_->engine(), 0);
  return report;
}

}  // namespace trephine::workbench
