#include "sim/replay.h"

#include <algorithm>
#include <charconv>
#include <cstdio>
#include <glm/geometric.hpp>

#include "haptics/force/effects.h"

namespace trephine::sim {

using volume::Error;
using volume::Result;
using volume::Status;

namespace {
constexpr std::uint64_t k_keep_every = 10'000;  // ticks between places to come back to

std::string hexadecimal(std::uint64_t v) {
  char text[20];
  std::snprintf(text, sizeof text, "%016llx", static_cast<unsigned long long>(v));
  return text;
}
std::string newtons(const glm::dvec3& f) {
  char text[120];
  std::snprintf(text, sizeof text, "(%.6f, %.6f, %.6f) N", f.x, f.y, f.z);
  return text;
}
}  // namespace

volume::Status check_recordable(const haptics::TouchScene& scene) {
  const auto no_words = [](const char* found) {
    return Error{"this scene cannot be recorded", "session", found, "up to 8 shapes of one volume",
                 "touch it without --record"};
  };
  for (const haptics::TouchItem& item : scene.items)
    if (item.is_mesh()) return no_words("polygonal models");
  if (scene.items.size() > haptics::TouchScene::k_max_shapes) return no_words("more shapes");
  for (const haptics::TouchItem& s : scene.items) {
    if (&s.field.volume() != scene.base.get()) return no_words("several volumes");
  }
  return std::nullopt;
}

std::shared_ptr<const haptics::LawSet> laws_of(const SessionHeader& header) {
  if (header.effects.empty()) return nullptr;
  auto laws = std::make_shared<haptics::LawSet>();
  for (const std::string& words : header.effects) {  // looked at when the header was read
    const auto id = static_cast<std::uint32_t>(laws->laws().size());
    laws->add(haptics::law_of(haptics::parse_effect(words).value(), id).value());
  }
  return laws;
}

SessionHeader describe_session(const haptics::TouchScene& scene, const haptics::ProxyMethod& method,
                               const haptics::ServoOptions& options, std::vector<ToolSpec> tools) {
  SessionHeader h;
  h.size = scene.base->size;
  h.rate_hz = options.rate_hz;
  h.method = method.name();
  h.force = options.force;
  for (const haptics::TouchItem& s : scene.items)
    h.shapes.push_back({s.field.shape(), s.material, s.sides, s.ramp, s.soft != nullptr, s.back_material});
  h.tool_radius = scene.tool_radius;
  h.smallest_burr = scene.smallest_burr;
  h.tools = std::move(tools);
  return h;
}

Result<haptics::TouchScene> scene_of(const SessionReader& session,
                                     std::shared_ptr<const volume::Volume> scan) {
  const SessionHeader& header = session.header();
  const auto no_match = [](std::string found, std::string expected) {
    return Error{"the scan is not the one of the session", "", std::move(found), std::move(expected),
                 "give the scan that was operated on: --case SRC; no --case where the session holds its own"};
  };
  const auto text_of = [](const glm::ivec3& s) {
    return std::to_string(s.x) + " x " + std::to_string(s.y) + " x " + std::to_string(s.z) + " voxels";
  };
  if (scan->size != header.size) return no_match(text_of(scan->size), text_of(header.size));
  if (session.scan_hash())
    if (const std::uint64_t hash = volume::content_hash(*scan); hash != *session.scan_hash())
      return no_match("voxels with hash " + hexadecimal(hash), "hash " + hexadecimal(*session.scan_hash()));
  haptics::TouchScene scene;
  std::vector<std::size_t> soft;
  for (const ShapeSpec& s : header.shapes) {
    if (s.shape.is_label() && scan->labels.is_empty()) return no_match("no labels", "label " + s.shape.name);
    auto bits = std::make_shared<const volume::Occupancy>(volume::Occupancy::build(*scan, s.shape));
    scene.items.push_back({volume::Field(*scan, s.shape), std::move(bits), s.material, s.sides});
    scene.items.back().ramp = s.ramp;
    scene.items.back().back_material = s.back_material;
    if (s.is_soft) soft.push_back(scene.items.size() - 1);
  }
  haptics::soften(scene, soft);
  scene.base = std::move(scan);
  if (Status error = haptics::set_tool_radius(scene, header.tool_radius)) return *error;
  if (Status error = haptics::set_smallest_burr(scene, header.smallest_burr)) return *error;
  return scene;
}

Replay::Replay(SessionReader& session, const haptics::TouchScene& scene, const haptics::ProxyMethod& method,
               std::vector<Tool*> tools)
    : session_(&session),
      scene_(&scene),
      method_(&method),
      tools_(std::move(tools)),
      dt_(1 / session.header().rate_hz) {
  TREPHINE_ASSERT(tools_.size() == session.header().tools.size());
  state_ = std::make_unique<State>(fresh_state());
  kept_.push_back(*state_);
  for (const Command& setting : state_->settings) state_->edits.apply(setting);
}

haptics::ServoCore Replay::make_core(std::size_t hand, std::uint64_t first_tick) const {
  return haptics::ServoCore(session_->header().force, dt_, hand, first_tick);
}

Replay::State Replay::fresh_state() const {
  const std::vector hands(tools_.size(),
                          haptics::ServoHand(haptics::borrowed(*scene_), haptics::borrowed(*method_),
                                             haptics::TouchState(nullptr), laws_of(session_->header())));
  State state{EditSession(hands, tools_, dt_), {}, {}, {}, {}, 0, {}};
  for (std::size_t h = 0; h < tools_.size(); ++h) {
    state.cores.push_back(make_core(h, 0));
    for (const auto& [name, value] : session_->header().tools[h].settings)
      state.settings.push_back({Command::Kind::set_tool, static_cast<std::uint8_t>(h), name, value});
  }
  state.seen.push_back(state.edits.servo_scene());
  return state;
}

Status Replay::restore(const State& state) {
  // Both ends of the way may look different: show everything that was cut.
  changed_ = {glm::ivec3(0), scene_->base->size - 1};
  state_ = std::make_unique<State>(state);
  for (Tool* tool : tools_)
    if (tool) tool->lift();
  for (const Command& setting : state_->settings) state_->edits.apply(setting);
  return session_->go_to(state_->place);
}

Status Replay::why_not_verifiable() const {
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
    if (!read.value()) return false;
    if (const auto* command = std::get_if<CommandItem>(&item)) {
      if (command->command.hand >= tools_.size())
        return Error{"the session's record is broken", "", "a command for a hand that it does not have", "",
                     ""};
      run_command(command->command);
    } else if (const auto* version = std::get_if<VersionItem>(&item)) {
      check(*version);
    } else if (const auto* hash = std::get_if<HashItem>(&item)) {
      check(*hash);
    } else {
      if (Status error = run_tick(std::get<TickItem>(item))) return *error;
      return true;
    }
  }
}

Status Replay::run_tick(const TickItem& item) {
  const haptics::ServoRecord& recorded = item.record;
  const auto broken = [&](const char* what) {
    return Error{"the session's record is broken", "tick " + std::to_string(recorded.tick), what, "", ""};
  };
  if (recorded.hand >= state_->cores.size()) return broken("a hand that the session does not have");
  haptics::ServoCore& core = state_->cores[recorded.hand];
  if (recorded.tick < core.next_tick()) return broken("ticks in no order");
  const std::uint64_t gap = recorded.tick - core.next_tick();
  {
    const haptics::DenormalsFlushed flushed;
    // Ticks that found no room in the ring: nothing was felt, and the force went on fading.
    if (gap > 0) core.skip(recorded.raised | haptics::fault_full_ring, gap);
    counts_.dropped += gap;
    auto& seen = state_->seen;
    while (seen.size() > 1 && seen.front()->serial < recorded.version && seen[1]->serial <= recorded.version)
      seen.pop_front();
    if (seen.front()->serial != recorded.version)
      note(recorded.tick, "version", std::to_string(recorded.version), std::to_string(seen.front()->serial));
    haptics::ServoInput input;
    input.pose = recorded.pose;
    input.faults = recorded.raised;
    input.is_reset = recorded.is_reset;
    input.is_restarted = recorded.is_restarted;
    input.restart_volume = recorded.restart_volume;
    record_ = core.step(*seen.front(), input);
  }
  recorded_force_ = recorded.force_world;
  if (output_check(record_) != item.check)
    note(recorded.tick, "force", newtons(recorded.force_world), newtons(record_.force_world));
  ++counts_.ticks;
  state_->next_tick = std::max(state_->next_tick, record_.tick + 1);
  const bool was_in_stroke = state_->edits.is_in_stroke();
  note_change(state_->edits.consume(record_));
  if (was_in_stroke && !state_->edits.is_in_stroke())
    state_->hashable[state_->edits.current()->serial()] = state_->edits.current();

  // Somewhere to come back to, now and then, when no tool is at work.
  if (!state_->edits.is_in_stroke() && state_->next_tick >= kept_.back().next_tick + k_keep_every) {
    kept_.push_back(*state_);
    kept_.back().place = session_->place();
  }
  return std::nullopt;
}

void Replay::note_change(const EditOutcome& outcome) {
  if (!outcome.is_changed) return;
  changed_ = united(changed_, outcome.box);
  state_->seen.push_back(state_->edits.servo_scene());
}

void Replay::run_command(const Command& command) {
  ++counts_.commands;
  const EditOutcome outcome = state_->edits.apply(command);
  if (command.kind == Command::Kind::set_tool) state_->settings.push_back(command);
  if (command.kind == Command::Kind::resume) ++counts_.resumes;
  if (command.kind == Command::Kind::resume)
    for (std::size_t h = 0; h < state_->cores.size(); ++h) state_->cores[h] = make_core(h, state_->next_tick);
  note_change(outcome);
  if (!state_->edits.is_in_stroke())
    state_->hashable[state_->edits.current()->serial()] = state_->edits.current();
}

void Replay::check(const VersionItem& item) {
  ++counts_.versions;
  const volume::Version& version = *state_->edits.current();
  if (version.serial() != item.serial)
    note(item.last_tick, "version", std::to_string(item.serial), std::to_string(version.serial()));
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
