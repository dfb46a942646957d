#include "sim/drivers/replay.h"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <glm/geometric.hpp>
#include <limits>

#include "haptics/servo/servo_memory.h"
#include "volume/base/text.h"

namespace trephine::sim {

using trephine::hexadecimal;
using trephine::text_of;

namespace {
constexpr std::uint64_t k_keep_every = 10'000;  // ticks between kept states

std::string newtons(const glm::dvec3& f) {
  char text[120];
  std::snprintf(text, sizeof text, "(%.6f, %.6f, %.6f) N", f.x, f.y, f.z);
  return text;
}

/// Freezes an engine and returns a copy. Only a frozen engine may be copied.
Engine frozen(Engine& engine) {
  engine.freeze();
  return engine;
}

/// Returns the modules of the session, in the order of its header.
Result<Catalogue> modules_of(const SessionReader& session) {
  std::vector<const Module*> modules;
  for (const NamedVersion& named : session.header().modules) {
    const std::vector<const Module*>& known = session.catalogue().modules();
    const auto found =
        std::find_if(known.begin(), known.end(), [&](const Module* m) { return m->name() == named.name; });
    if (found == known.end())
      return Error{.what = "the session uses the module " + named.name + " " + std::to_string(named.version),
                   .where = "module",
                   .found = "a program without this module",
                   .remedy = "load the module"};
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
  if (data.streams.empty()) {
    auto streams = session.streams();
    if (!streams) return streams.error();
    data.streams = std::move(streams).value();
  }
  auto start = build_scene(header, data, modules.value());
  if (!start) return start.error();
  return open(session, std::move(start).value());
}

Result<std::unique_ptr<Replay>> Replay::open(SessionReader& session, OperationStart start) {
  const SessionHeader& header = session.header();
  Result<Catalogue> modules = modules_of(session);
  if (!modules) return modules.error();
  std::unique_ptr<Replay> replay(
      new Replay(session, Engine(std::move(start.hands), 1 / header.rate_hz, modules.value(),
                                 std::move(start.forbidden), std::move(start.plan))));
  // The state of a module of another version may have another meaning.
  for (const NamedVersion& named : header.modules)
    for (const Module* module : modules.value().modules())
      if (module->name() == named.name && module->version() != named.version)
        replay->are_checkpoints_usable_ = false;
  return replay;
}

Replay::Replay(SessionReader& session, Engine engine)
    : session_(&session), dt_(1 / session.header().rate_hz), checkpoints_(session, frozen(engine)) {
  ServoFollower servo(session.header().force, dt_, engine.hand_count(), engine.servo_scene());
  const std::size_t hands = engine.hand_count();
  state_ =
      std::make_unique<State>(State{std::move(engine), std::move(servo), {}, 0, 0, 0, 0, false, {}, {}, {}});
  state_->records.resize(hands);
  keep();
}

/// Keeps a copy of the current state, to which seek() can return.
void Replay::keep() {
  state_->engine.freeze();
  state_->position = session_->position();
  kept_states_.push_back(*state_);
}

Status Replay::restore(State state) {
  // Anything may look different between the two states.
  changed_ = {glm::ivec3(0), state.engine.scene().base->size - 1};
  const SessionReader::Position position = state.position;
  state_ = std::make_unique<State>(std::move(state));
  compared_checkpoint_.reset();
  return session_->go_to(position);
}

/// Goes to a checkpoint. Error if it does not match this session; the state is then undefined.
Status Replay::open_at(std::size_t checkpoint) {
  Result<Checkpoint> read = checkpoints_.read(checkpoint);
  if (!read) return read.error();
  const Checkpoint& stored = read.value();
  State opened = kept_states_.front();
  if (Status error = opened.engine.restore(stored.snapshot)) return error;
  opened.servo =
      ServoFollower(session_->header().force, dt_, opened.engine.hand_count(), opened.engine.servo_scene());
  opened.events = stored.snapshot.state.chronicle.size();
  opened.next_tick = stored.snapshot.state.next_tick;
  opened.opened_at = stored.snapshot.serial;
  opened.versions_to_check = {
      {stored.snapshot.serial, opened.engine.version()}};  // its hash follows in the log
  opened.position = {stored.block, 0};
  opened.fields = stored.fields;
  if (Status error = restore(std::move(opened))) return error;
  const Error wrong{"a checkpoint of the session is broken", "", "it does not match the ticks after it", "",
                    ""};
  LogItem item;
  std::vector<std::uint64_t> next_ticks(state_->engine.hand_count());
  for (const haptics::ServoRecord& record : stored.records) {
    next_ticks[record.hand] = record.tick + 1;
    const TickItem* tick = nullptr;
    while (tick == nullptr) {
      const Result<bool> next = session_->next(item);
      if (!next) return next.error();
      if (!next.value()) return wrong;
      if ((tick = std::get_if<TickItem>(&item)) == nullptr)
        if (Status error = process_item(item)) return error;
    }
    if (tick->record.tick != record.tick || tick->record.hand != record.hand ||
        tick->check != output_check(record))
      return wrong;
    state_->servo.advance_to(record.version);
    record_ = record;
    state_->records[record_.hand] = record_;
    recorded_force_ = tick->record.force_world;
    finish_tick(false);
  }
  std::vector<haptics::ServoCore> cores = state_->servo.cores();
  for (std::size_t h = 0; h < cores.size(); ++h)
    if (!haptics::ServoMemory::load(stored.cores[h], state_->servo.current_scene()->hands[h], cores[h]) ||
        cores[h].next_tick() != next_ticks[h])
      return wrong;
  if (state_->next_tick != stored.next_tick) return wrong;
  state_->servo.set_cores(std::move(cores));
  return std::nullopt;
}

SessionTail Replay::tail() {
  return {session_->complete_bytes(), session_->block_count(), session_->log_count(), session_->types(),
          checkpoints_.tail()};
}

Status Replay::reason_not_verifiable() const {
  for (const NamedVersion& named : session_->header().modules)
    for (const Module* module : session_->catalogue().modules())
      if (module->name() == named.name && module->version() != named.version)
        return Error{.what = "the session cannot be verified, only viewed",
                     .found = "module " + named.name + " of version " + std::to_string(named.version),
                     .expected = "version " + std::to_string(module->version()),
                     .remedy = "verify it with the version that recorded it"};
  const std::uint32_t revision = session_->header().revision;
  if (revision == k_replay_revision) return std::nullopt;
  return Error{.what = "the session cannot be verified, only viewed",
               .found = "recorded by " + session_->header().program + ", arithmetic revision " +
                        std::to_string(revision),
               .expected = "revision " + std::to_string(k_replay_revision),
               .remedy = "verify it with the version that recorded it"};
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
    if (is_verifying_) compare_checkpoint();
    if (const auto* tick = std::get_if<TickItem>(&item)) {
      if (Status error = run_tick(*tick)) return *error;
      return true;
    }
    if (Status error = process_item(item)) return *error;
  }
}

/// Handles an item other than a tick.
Status Replay::process_item(const LogItem& item) {
  if (const auto* command = std::get_if<CommandItem>(&item)) {
    if (command->command.hand >= state_->engine.hand_count())
      return Error{.what = "the session's record is damaged",
                   .found = "a command of a hand that the session does not have"};
    run_command(command->command);
  } else if (const auto* version = std::get_if<VersionItem>(&item)) {
    check(*version);
  } else if (const auto* hash = std::get_if<HashItem>(&item)) {
    check(*hash);
  } else if (const auto* event = std::get_if<EventItem>(&item)) {
    check(*event);
  } else if (const auto* unknown = std::get_if<UnknownItem>(&item)) {
    const NamedVersion& type = session_->header().types[unknown->type];
    return Error{.what = "this program does not know a command or event of the session",
                 .found = type.name,
                 .expected = "version " + std::to_string(type.version),
                 .remedy = "open it with the version that recorded it"};
  }
  return std::nullopt;
}

/// Compares the next checkpoint with the state, if the last item read begins its block.
void Replay::compare_checkpoint() {
  const SessionReader::Position position = session_->position();
  while (next_checkpoint_ < checkpoints_.size() &&
         checkpoints_.index(next_checkpoint_).block < position.block)
    ++next_checkpoint_;
  if (position.items != 1 || next_checkpoint_ == checkpoints_.size() ||
      checkpoints_.index(next_checkpoint_).block != position.block)
    return;
  const std::uint64_t tick = state_->next_tick;
  Result<Checkpoint> read = checkpoints_.read(next_checkpoint_);
  if (!read) return record_mismatch(tick, "checkpoint", read.error().found, "one that can be read");
  ++counts_.checkpoints;
  const Checkpoint& stored = read.value();
  const EngineSnapshot snapshot = state_->engine.full_snapshot();
  if (bytes_without_state(stored.snapshot) != bytes_without_state(snapshot))
    record_mismatch(tick, "checkpoint", "history, trails and settings of the checkpoint",
                    "other history, trails or settings");
  // After many cuts the hash takes longer than the replay that it checks: then only some hashes are compared.
  constexpr int k_many_bricks = 1 << 13;
  constexpr std::size_t k_compared = 16;  // every 16th checkpoint
  if (snapshot.state.undoable.version->brick_count() > k_many_bricks && next_checkpoint_ % k_compared != 0) {
    const volume::RemovalLedger &recorded = stored.snapshot.state.undoable.version->ledger(),
                                &here = snapshot.state.undoable.version->ledger();
    if (recorded.total() != here.total() || recorded.detached_units != here.detached_units)
      record_mismatch(tick, "checkpoint", "removed volume of the checkpoint", "another removed volume");
  } else if (const std::uint64_t recorded = stored.snapshot.state.hash(), replayed = snapshot.state.hash();
             recorded != replayed) {
    record_mismatch(tick, "checkpoint", hexadecimal(recorded), hexadecimal(replayed));
  }
  Engine opened = kept_states_.front().engine;
  if (const Status error = opened.restore(stored.snapshot))
    record_mismatch(tick, "checkpoint", error->message(), "");
  compared_checkpoint_ = std::move(read).value();
  compared_ticks_ = 0;
}

/// Compares the newest tick with the corresponding tick of the checkpoint. After the last tick of the
/// checkpoint, also compares the memory of the servo.
void Replay::compare_tick() {
  const auto bytes_of = [](const haptics::ServoRecord& record) {
    std::string bytes;
    haptics::put_record(bytes, record);
    return bytes;
  };
  const Checkpoint& stored = *compared_checkpoint_;
  if (compared_ticks_ < stored.records.size() &&
      bytes_of(stored.records[compared_ticks_]) != bytes_of(record_))
    record_mismatch(record_.tick, "checkpoint", "tick after the checkpoint", "another result of this tick");
  if (++compared_ticks_ < stored.records.size()) return;
  for (std::size_t h = 0; h < stored.cores.size(); ++h) {
    const haptics::ServoHand& hand = state_->servo.current_scene()->hands[h];
    haptics::ServoCore loaded = state_->servo.cores()[h];
    if (haptics::ServoMemory::save(loaded, hand) != stored.cores[h])
      record_mismatch(record_.tick, "checkpoint", "servo memory of the checkpoint", "another servo memory");
    else if (!haptics::ServoMemory::load(stored.cores[h], hand, loaded))
      record_mismatch(record_.tick, "checkpoint", "a servo that cannot be loaded", "");
  }
  compared_checkpoint_.reset();
}

Status Replay::run_tick(const TickItem& item) {
  const haptics::ServoRecord& recorded = item.record;
  if (!state_->servo.can_follow(recorded))
    return Error{.what = "the session's record is damaged",
                 .where = "tick " + std::to_string(recorded.tick),
                 .found = recorded.hand >= state_->engine.hand_count()
                              ? "a hand that the session does not have"
                              : "ticks out of order"};
  if (requested_parts_ && requested_parts_->first == recorded.tick &&
      requested_parts_->second == recorded.hand)
    parts_ = state_->servo.force_parts(recorded);
  record_ = state_->servo.step(recorded);
  state_->records[record_.hand] = record_;
  counts_.dropped += state_->servo.gap();
  state_->dropped += state_->servo.gap();
  if (const std::uint64_t serial = state_->servo.current_scene()->serial; serial != recorded.version)
    record_mismatch(recorded.tick, "version", std::to_string(recorded.version), std::to_string(serial));
  recorded_force_ = recorded.force_world;
  // The check covers every output; force and contact are also stored, for programs that only read them.
  if (output_check(record_) != item.check || recorded.force_world != logged_force(record_.force_world))
    record_mismatch(recorded.tick, "force", newtons(recorded.force_world), newtons(record_.force_world));
  if (recorded.has_contact != record_.has_contact)
    record_mismatch(recorded.tick, "contact", recorded.has_contact ? "yes" : "no",
                    record_.has_contact ? "yes" : "no");
  if (compared_checkpoint_) compare_tick();
  finish_tick();
  return std::nullopt;
}

/// Applies `record_`, which the servo has replayed, to the engine.
void Replay::finish_tick(bool may_keep) {
  ++counts_.ticks;
  state_->next_tick = std::max(state_->next_tick, record_.tick + 1);
  state_->is_in_tick = record_.hand + 1u < state_->engine.hand_count();
  const bool was_in_stroke = state_->engine.is_in_stroke();
  add_change(state_->engine.apply(record_));
  if (was_in_stroke && !state_->engine.is_in_stroke())
    state_->versions_to_check[state_->engine.serial()] = state_->engine.version();
  if (++state_->replayed < kept_states_.back().replayed + k_keep_every || !may_keep ||
      state_->next_tick <= kept_states_.back().next_tick)
    return;
  // No state is kept near a checkpoint, from which seek() can also start.
  const auto near = are_checkpoints_usable_ ? checkpoints_.before(state_->next_tick) : std::nullopt;
  if (!near || checkpoints_.index(*near).next_tick + k_keep_every < state_->next_tick) keep();
}

void Replay::add_change(const Outcome& outcome) {
  if (!outcome.is_changed) return;
  changed_ = union_of(changed_, outcome.box);
  state_->servo.publish(state_->engine.servo_scene());
}

void Replay::run_command(const Command& command) {
  ++counts_.commands;
  const auto* adopt = command.request.as<Adopt>();
  if (adopt && adopt->kind == DerivedKind::offset_fields)
    for (const Checkpoint::Fields& result : state_->fields)
      if (result.serial == static_cast<std::uint64_t>(adopt->serial) && result.hand == command.hand) {
        DerivedJob job{{adopt->kind, adopt->item, command.hand}, result.serial, adopt->input};
        job.scene = state_->engine.tool(command.hand).scene;
        state_->engine.submit_result(job, {result.offsets});
      }
  const Outcome outcome = state_->engine.apply(command);
  const std::string name(command.request.name());
  // A refusal by the procedure is in the log, with its event.
  if (outcome.refused && !outcome.is_refusal_recorded)
    record_mismatch(state_->next_tick, "command", name + ' ' + command.request.words(),
                    outcome.refused->message());
  const auto compare = [&](const auto* adoption, const char* what) {
    if (adoption && outcome.job_hash && *outcome.job_hash != static_cast<std::uint64_t>(adoption->hash))
      record_mismatch(state_->next_tick, what, hexadecimal(static_cast<std::uint64_t>(adoption->hash)),
                      hexadecimal(*outcome.job_hash));
  };
  compare(adopt, "derived data");
  compare(command.request.as<AdoptJob>(), "job");
  if (command.request.as<Resume>()) {
    ++counts_.resumes;
    state_->dropped = 0;
    state_->servo.restart(state_->next_tick);
  }
  add_change(outcome);
  if (!state_->engine.is_in_stroke())
    state_->versions_to_check[state_->engine.serial()] = state_->engine.version();
}

void Replay::check(const EventItem& item) {
  ++counts_.events;
  const Chronicle& chronicle = state_->engine.state().chronicle;
  const auto words = [](const Event& e) {
    return std::string(e.value.name()) + ' ' + e.value.words() + " at tick " + std::to_string(e.tick);
  };
  if (state_->events >= chronicle.size())
    return record_mismatch(item.event.tick, "event", words(item.event), "none");
  const Event& replayed = chronicle[state_->events++];
  if (replayed.tick != item.event.tick || replayed.hand != item.event.hand ||
      replayed.position_world != item.event.position_world || !(replayed.value == item.event.value))
    record_mismatch(item.event.tick, "event", words(item.event), words(replayed));
}

void Replay::check(const VersionItem& item) {
  ++counts_.versions;
  const volume::Version& version = *state_->engine.version();
  if (state_->engine.serial() != item.serial)
    record_mismatch(item.last_tick, "version", std::to_string(item.serial),
                    std::to_string(state_->engine.serial()));
  else if (version.ledger().total() != item.removed_units)
    record_mismatch(item.last_tick, "removed volume", std::to_string(item.removed_units) + " units",
                    std::to_string(version.ledger().total()) + " units");
}

void Replay::check(const HashItem& item) {
  if (item.serial < state_->opened_at) return;  // the version is older than the opened checkpoint
  ++counts_.hashes;
  const auto found = state_->versions_to_check.find(item.serial);
  const std::string recorded = hexadecimal(item.hash);
  if (found == state_->versions_to_check.end())
    return record_mismatch(state_->next_tick, "voxels", recorded,
                           "no version " + std::to_string(item.serial));
  if (const std::uint64_t hash = found->second->content_hash(); hash != item.hash)
    record_mismatch(state_->next_tick, "voxels", recorded, hexadecimal(hash));
  state_->versions_to_check.erase(state_->versions_to_check.begin(), std::next(found));
}

/// Compares the final state with the end of the session.
void Replay::check_end() {
  const std::optional<SessionEnd>& end = session_->end();
  if (!end) return;
  if (session_->lost_bytes() > 0)
    record_mismatch(state_->next_tick, "end", std::to_string(session_->lost_bytes()) + " bytes after it",
                    "none");
  const Engine& engine = state_->engine;
  const auto compare = [&](const char* what, std::uint64_t recorded, std::uint64_t replayed) {
    if (recorded != replayed)
      record_mismatch(state_->next_tick, what, std::to_string(recorded), std::to_string(replayed));
  };
  compare("ticks", end->ticks, state_->next_tick);
  compare("version", end->serial, engine.serial());
  // A replay that began at a checkpoint has not counted the ticks that were dropped before it.
  if (state_->opened_at == 0) compare("dropped ticks", end->dropped, state_->dropped);
  if (const std::uint64_t hash = engine.version()->content_hash(); hash != end->hash)
    record_mismatch(state_->next_tick, "voxels", hexadecimal(end->hash), hexadecimal(hash));
  if (engine.removed_mm3() != end->removed_mm3)
    record_mismatch(state_->next_tick, "removed volume", rounded_text(end->removed_mm3) + " mm3",
                    rounded_text(engine.removed_mm3()) + " mm3");
  if (const std::uint64_t state = engine.state().hash(); state != end->state)
    record_mismatch(state_->next_tick, "state", hexadecimal(end->state), hexadecimal(state));
  const std::vector<Measure> measures = engine.measures();
  for (const Measure& recorded : end->measures) {
    const auto replayed = std::find_if(measures.begin(), measures.end(),
                                       [&](const Measure& one) { return one.name == recorded.name; });
    if (replayed == measures.end() || replayed->value != recorded.value)
      record_mismatch(state_->next_tick, "measure", recorded.name + ' ' + text_of(recorded.value),
                      replayed == measures.end() ? "none" : text_of(replayed->value));
  }
  if (state_->events != engine.state().chronicle.size())
    record_mismatch(state_->next_tick, "events", std::to_string(state_->events),
                    std::to_string(engine.state().chronicle.size()));
}

void Replay::record_mismatch(std::uint64_t tick, const char* what, std::string recorded,
                             std::string replayed) {
  if (!mismatch_) mismatch_ = Mismatch{tick, what, std::move(recorded), std::move(replayed)};
}

Status Replay::seek(std::uint64_t tick) {
  const Result<bool> arrived = seek_for(tick, std::numeric_limits<double>::infinity());
  return arrived ? std::nullopt : Status(arrived.error());
}

Result<bool> Replay::seek_for(std::uint64_t tick, double seconds) {
  const auto begin = std::chrono::steady_clock::now();
  // Starts from the newest state before the tick: the current one, a kept one, or a checkpoint.
  const auto first_later = std::partition_point(kept_states_.begin(), kept_states_.end(),
                                                [tick](const State& s) { return s.next_tick <= tick; });
  const auto start = static_cast<std::size_t>(
      first_later == kept_states_.begin() ? 0 : first_later - kept_states_.begin() - 1);
  bool is_current_usable = state_->next_tick <= tick && state_->next_tick >= kept_states_[start].next_tick;
  const std::uint64_t known = is_current_usable ? state_->next_tick : kept_states_[start].next_tick;
  bool is_opened = false;
  if (const auto newest = are_checkpoints_usable_ ? checkpoints_.before(tick) : std::nullopt)
    for (std::size_t i = *newest + 1; !is_opened && i-- > 0 && checkpoints_.index(i).next_tick > known;) {
      if (failed_checkpoints_.contains(i)) continue;
      is_opened = !open_at(i);
      if (!is_opened) failed_checkpoints_.insert(i);
      ++(is_opened ? counts_.opened_checkpoints : counts_.failed_checkpoints);
      if (!is_opened) is_current_usable = false;
    }
  if (!is_opened && !is_current_usable)
    if (Status error = restore(kept_states_[start])) return *error;
  // At the end of the session, continues beyond the first record of the last tick: the other hands have
  // records of this tick too, and commands may follow.
  const bool is_to_end = tick >= session_->tick_count();
  while (state_->next_tick < tick || state_->is_in_tick || is_to_end) {
    const Result<bool> stepped = step();
    if (!stepped) return stepped.error();
    if (!stepped.value()) break;
    if (std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count() > seconds)
      return !is_to_end && state_->next_tick >= tick && !state_->is_in_tick;
  }
  return true;
}

volume::VoxelBox Replay::take_changed() noexcept {
  return std::exchange(changed_, volume::VoxelBox{glm::ivec3(0), glm::ivec3(-1)});
}

}  // namespace trephine::sim
