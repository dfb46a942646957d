#include "sim/replay.h"

#include <algorithm>
#include <cstdio>
#include <glm/geometric.hpp>

#include "sim/text.h"

namespace trephine::sim {

using volume::Error;
using volume::Result;
using volume::Status;

namespace {
constexpr std::uint64_t k_keep_every = 10'000;  // ticks between places to come back to

std::string newtons(const glm::dvec3& f) {
  char text[120];
  std::snprintf(text, sizeof text, "(%.6f, %.6f, %.6f) N", f.x, f.y, f.z);
  return text;
}

/// The session's modules, in its order.
Result<Catalogue> modules_of(const SessionReader& session) {
  std::vector<const Module*> modules;
  for (const NamedVersion& named : session.header().modules) {
    const std::vector<const Module*>& all = session.catalogue().modules();
    const auto found =
        std::find_if(all.begin(), all.end(), [&](const Module* m) { return m->name() == named.name; });
    if (found == all.end())
      return Error{"this program does not have a module of the session", "", named.name, "",
                   "open it with the version that recorded it"};
    modules.push_back(*found);
  }
  return Catalogue(std::move(modules));
}
}  // namespace

Result<std::unique_ptr<Replay>> Replay::open(SessionReader& session, SceneData data) {
  const SessionHeader& header = session.header();
  Result<Catalogue> modules = modules_of(session);
  if (!modules) return modules.error();
  for (std::size_t v = data.volumes.size(); v < std::min(session.scan_count(), header.volumes.size()); ++v) {
    Result<volume::Volume> scan = session.scan(v);
    if (!scan) return scan.error();
    data.volumes.push_back(std::make_shared<const volume::Volume>(std::move(scan).value()));
  }
  if (data.models.empty()) {
    auto models = session.models();
    if (!models) return models.error();
    data.models = std::move(models).value();
  }
  auto start = build_scene(header, data, modules.value());
  if (!start) return start.error();
  return std::unique_ptr<Replay>(
      new Replay(session, Engine(std::move(start.value().hands), 1 / header.rate_hz, modules.value(),
                                 std::move(start.value().forbidden))));
}

Replay::Replay(SessionReader& session, Engine engine)
    : session_(&session), dt_(1 / session.header().rate_hz) {
  ServoFollower servo(session.header().force, dt_, engine.hand_count(), engine.servo_scene());
  state_ = std::make_unique<State>(State{std::move(engine), std::move(servo), {}, 0, 0, 0, {}});
  keep();
}

/// Somewhere to come back to.
void Replay::keep() {
  state_->engine.freeze();
  state_->place = session_->place();
  kept_.push_back(*state_);
}

Status Replay::restore(const State& state) {
  // Both ends of the way may look different: show everything that was cut.
  changed_ = {glm::ivec3(0), state.engine.scene().base->size - 1};
  state_ = std::make_unique<State>(state);
  return session_->go_to(state_->place);
}

Status Replay::why_not_verifiable() const {
  for (const NamedVersion& named : session_->header().modules)
    for (const Module* module : session_->catalogue().modules())
      if (module->name() == named.name && module->version() != named.version)
        return Error{"the session cannot be verified, only viewed", "",
                     "module " + named.name + " of version " + std::to_string(named.version),
                     "version " + std::to_string(module->version()),
                     "verify it with the version that recorded it, or leave --verify out"};
  const std::uint32_t revision = session_->header().revision;
  if (revision == k_replay_revision) return std::nullopt;
  return Error{
      "the session cannot be verified, only viewed", "",
      "recorded by " + session_->header().program + ", arithmetic revision " + std::to_string(revision),
      "revision " + std::to_string(k_replay_revision),
      "verify it with the version that recorded it, or leave --verify out"};
}

Result<bool> Replay::step() {
  LogItem item;
  for (;;) {
    const Result<bool> read = session_->next(item);
    if (!read) return read.error();
    if (!read.value()) {
      check_end();
      return false;
    }
    if (const auto* command = std::get_if<CommandItem>(&item)) {
      if (command->command.hand >= state_->engine.hand_count())
        return Error{"the session's record is broken", "", "a command for a hand that it does not have", "",
                     ""};
      run_command(command->command);
    } else if (const auto* version = std::get_if<VersionItem>(&item)) {
      check(*version);
    } else if (const auto* hash = std::get_if<HashItem>(&item)) {
      check(*hash);
    } else if (const auto* event = std::get_if<EventItem>(&item)) {
      check(*event);
    } else if (const auto* unknown = std::get_if<UnknownItem>(&item)) {
      const NamedVersion& type = session_->header().types[unknown->type];
      return Error{"this program does not know a command of the session", "", type.name,
                   "version " + std::to_string(type.version), "open it with the version that recorded it"};
    } else {
      if (Status error = run_tick(std::get<TickItem>(item))) return *error;
      return true;
    }
  }
}

Status Replay::run_tick(const TickItem& item) {
  const haptics::ServoRecord& recorded = item.record;
  if (!state_->servo.can_follow(recorded))
    return Error{"the session's record is broken", "tick " + std::to_string(recorded.tick),
                 recorded.hand >= state_->engine.hand_count() ? "a hand that the session does not have"
                                                              : "ticks in no order",
                 "", ""};
  record_ = state_->servo.step(recorded);
  counts_.dropped += state_->servo.gap();
  if (const std::uint64_t serial = state_->servo.seen()->serial; serial != recorded.version)
    note(recorded.tick, "version", std::to_string(recorded.version), std::to_string(serial));
  recorded_force_ = recorded.force_world;
  if (output_check(record_) != item.check)
    note(recorded.tick, "force", newtons(recorded.force_world), newtons(record_.force_world));
  ++counts_.ticks;
  state_->next_tick = std::max(state_->next_tick, record_.tick + 1);
  const bool was_in_stroke = state_->engine.is_in_stroke();
  note_change(state_->engine.apply(record_));
  if (was_in_stroke && !state_->engine.is_in_stroke())
    state_->hashable[state_->engine.serial()] = state_->engine.current();
  if (++state_->replayed >= kept_.back().replayed + k_keep_every) keep();
  return std::nullopt;
}

void Replay::note_change(const Outcome& outcome) {
  if (!outcome.is_changed) return;
  changed_ = united(changed_, outcome.box);
  state_->servo.publish(state_->engine.servo_scene());
}

void Replay::run_command(const Command& command) {
  ++counts_.commands;
  const Outcome outcome = state_->engine.apply(command);
  const std::string name(command.what.name());
  if (outcome.refused)
    note(state_->next_tick, "command", name + ' ' + command.what.words(), outcome.refused->message());
  if (const auto* adopt = command.what.as<AdoptJob>())
    if (outcome.job_hash && *outcome.job_hash != static_cast<std::uint64_t>(adopt->hash))
      note(state_->next_tick, "job", hexadecimal(static_cast<std::uint64_t>(adopt->hash)),
           hexadecimal(*outcome.job_hash));
  if (command.what.as<Resume>()) {
    ++counts_.resumes;
    state_->servo.begin_anew(state_->next_tick);
  }
  note_change(outcome);
  if (!state_->engine.is_in_stroke()) state_->hashable[state_->engine.serial()] = state_->engine.current();
}

void Replay::check(const EventItem& item) {
  ++counts_.events;
  const Chronicle& all = state_->engine.now().chronicle;
  const auto words = [](const Event& e) {
    return std::string(e.what.name()) + ' ' + e.what.words() + " at tick " + std::to_string(e.tick);
  };
  if (state_->events >= all.size()) return note(item.event.tick, "event", words(item.event), "none");
  const Event& here = all[state_->events++];
  if (here.tick != item.event.tick || here.hand != item.event.hand ||
      here.place_world != item.event.place_world || !(here.what == item.event.what))
    note(item.event.tick, "event", words(item.event), words(here));
}

void Replay::check(const VersionItem& item) {
  ++counts_.versions;
  const volume::Version& version = *state_->engine.current();
  if (state_->engine.serial() != item.serial)
    note(item.last_tick, "version", std::to_string(item.serial), std::to_string(state_->engine.serial()));
  else if (version.ledger().total() != item.removed_units)
    note(item.last_tick, "removed volume", std::to_string(item.removed_units) + " units",
         std::to_string(version.ledger().total()) + " units");
}

void Replay::check(const HashItem& item) {
  ++counts_.hashes;
  const auto found = state_->hashable.find(item.serial);
  const std::string recorded = hexadecimal(item.hash);
  if (found == state_->hashable.end())
    return note(state_->next_tick, "voxels", recorded, "no version " + std::to_string(item.serial));
  if (const std::uint64_t hash = found->second->content_hash(); hash != item.hash)
    note(state_->next_tick, "voxels", recorded, hexadecimal(hash));
  state_->hashable.erase(state_->hashable.begin(), std::next(found));
}

/// The end says the whole state once more.
void Replay::check_end() {
  const std::optional<SessionEnd>& end = session_->end();
  if (!end) return;
  const Engine& engine = state_->engine;
  if (const std::uint64_t hash = engine.current()->content_hash(); hash != end->hash)
    note(state_->next_tick, "voxels", hexadecimal(end->hash), hexadecimal(hash));
  if (engine.removed_mm3() != end->removed_mm3)
    note(state_->next_tick, "removed volume", std::to_string(end->removed_mm3) + " mm3",
         std::to_string(engine.removed_mm3()) + " mm3");
  if (const std::uint64_t state = engine.now().hash(); state != end->state)
    note(state_->next_tick, "state", hexadecimal(end->state), hexadecimal(state));
  if (state_->events != engine.now().chronicle.size())
    note(state_->next_tick, "events", std::to_string(state_->events),
         std::to_string(engine.now().chronicle.size()));
}

void Replay::note(std::uint64_t tick, const char* what, std::string recorded, std::string replayed) {
  if (!mismatch_) mismatch_ = Mismatch{tick, what, std::move(recorded), std::move(replayed)};
}

Status Replay::seek(std::uint64_t tick) {
  // The newest kept state before the tick, unless going on from here is shorter.
  const auto after = std::partition_point(kept_.begin(), kept_.end(),
                                          [tick](const State& s) { return s.next_tick <= tick; });
  const State& before = after == kept_.begin() ? kept_.front() : *std::prev(after);
  if (tick < state_->next_tick || before.next_tick > state_->next_tick)
    if (Status error = restore(before)) return error;
  // To the end means to its end: commands may follow the last tick, and hands share it.
  const bool is_to_end = tick >= session_->tick_count();
  while (state_->next_tick < tick || is_to_end) {
    const Result<bool> stepped = step();
    if (!stepped) return stepped.error();
    if (!stepped.value()) break;
  }
  return std::nullopt;
}

volume::VoxelBox Replay::take_changed() noexcept {
  return std::exchange(changed_, volume::VoxelBox{glm::ivec3(0), glm::ivec3(-1)});
}

}  // namespace trephine::sim
