#include "sim/session/checkpoint_format.h"

#include <algorithm>
#include <set>

#include "haptics/servo/servo_memory.h"
#include "sim/session/compression.h"
#include "volume/base/bytes.h"
#include "volume/cuts/version_changes.h"
#include "volume/fields/offset_changes.h"

namespace trephine::sim {

using trephine::get;
using trephine::get_number;
using trephine::get_text;
using trephine::put;
using trephine::put_number;
using trephine::put_text;

namespace {

/// A chain starts again from the uncut state if it exceeds both k_short_chain bytes and k_longest_chain
/// times the bytes of its first link, since a reader of the last link reads all links.
constexpr std::size_t k_short_chain = 1 << 20, k_longest_chain = 2;

void put_count(std::string& out, std::uint64_t value) { put_number(out, static_cast<std::int64_t>(value)); }

void put_box(std::string& out, const volume::VoxelBox& box) {
  for (const glm::ivec3& corner : {box.low, box.high})
    for (int a = 0; a < 3; ++a) put_number(out, corner[a]);
}

/// Writes a value whose type the reader knows.
void put_bytes_of(std::string& out, const Value* value) {
  put_text(out, value && !value->is_empty() ? value->bytes() : std::string());
}
void put_modules(std::string& out, const std::vector<std::shared_ptr<const Value>>& modules) {
  put_count(out, modules.size());
  for (const auto& module : modules) put_bytes_of(out, module.get());
}
void put_value(std::string& out, const Value& value) {
  put_text(out, value.is_empty() ? std::string_view() : value.name());
  put_bytes_of(out, &value);
}

void put_placement(std::string& out, const haptics::Placement& at) {
  put(out, at.position_world);
  const glm::dquat& q = at.rotation;
  for (const double part : {q.w, q.x, q.y, q.z}) put(out, part);
}

void put_hand(std::string& out, const EngineSnapshot::Hand& hand) {
  const haptics::ToolShape& tool = *hand.tool.scene->tool;
  ToolGeometry geometry = ToolGeometry::of(tool);
  if (tool.mesh()) geometry.spacing = k_spacing_of_model;
  put(out, geometry.radius);
  put_count(out, geometry.balls.size());
  for (const glm::dvec3& centre : geometry.balls) put(out, centre);
  put_count(out, geometry.profile.size());
  for (const double value : geometry.profile) put(out, value);
  put(out, geometry.spacing);
  put_count(out, hand.tool.change_count);
  put(out, static_cast<std::uint8_t>(hand.escape_path != nullptr));
  if (hand.escape_path) {
    put(out, hand.escape_path->serial);
    put_count(out, hand.escape_path->count);
    for (std::uint32_t i = 0; i < hand.escape_path->count; ++i)
      put(out, hand.escape_path->positions_volume[i]);
  }
  put(out, static_cast<std::uint8_t>(hand.work.is_pressed | hand.work.is_fresh << 1 |
                                     hand.work.instrument_ball.has_value() << 2 |
                                     hand.work.placement.has_value() << 3));
  put(out, hand.work.noted_faults);
  if (hand.work.instrument_ball)
    put(out, hand.work.instrument_ball->centre), put(out, hand.work.instrument_ball->radius);
  if (hand.work.placement) put_placement(out, *hand.work.placement);
}

/// Writes the cuts that the fields do not include.
void put_cuts(std::string& out, const TouchFields& fields) {
  const auto cuts = fields.cuts();
  put_count(out, cuts.size());
  for (const auto& [serial, box] : cuts) {
    put(out, serial);
    put_box(out, box);
  }
}

/// Writes the counts of a snapshot, and the boxes of its cuts.
void put_numbers(std::string& out, const EngineSnapshot& snapshot) {
  for (const std::uint64_t number : {snapshot.last_entry, snapshot.addition_count,
                                     std::uint64_t{snapshot.last_job}, std::uint64_t{snapshot.last_body}})
    put_count(out, number);
  put(out, static_cast<std::uint8_t>(snapshot.is_stroke_changed));
  put_box(out, snapshot.stroke_box);
  put_box(out, snapshot.all_cuts_box);
}

/// Calls each(branch), for the current branch first.
template <class Each>
void for_branches(const EngineSnapshot& snapshot, Each&& each) {
  each(snapshot.branch);
  for (const Branch& one : snapshot.other_branches) each(one);
}

/// Writes a job without the state in which it began.
void put_job(std::string& out, const PendingJob& job) {
  put_count(out, job.id.value);
  put(out, job.hand);
  put_value(out, *job.parameters);
  put_count(out, job.addition_count);
  put_box(out, job.cut);
}

/// Returns the first hand with this scene; the number of hands if no hand has it any more.
std::size_t hand_of(const Checkpoint& checkpoint, const std::shared_ptr<const haptics::TouchScene>& scene) {
  std::size_t h = 0;
  while (h < checkpoint.snapshot.hands.size() && checkpoint.snapshot.hands[h].tool.scene != scene) ++h;
  return h;
}

}  // namespace

void CheckpointEncoder::put_link(const ChainLink& link, const std::string& bytes) {
  ++link_count_;
  put_count(links_, link.chain);
  put_count(links_, link.number);
  put(links_, static_cast<std::uint8_t>(link.is_first));
  put_text(links_, compress(bytes));
}

std::uint64_t CheckpointEncoder::link_of(const std::shared_ptr<const volume::Version>& version) {
  if (version == tail_.version) return tail_.next_link - 1;
  ChainLink link{0, tail_.next_link++,
                 !tail_.version || chain_bytes_ > std::max(k_short_chain, k_longest_chain * first_bytes_)};
  const std::string bytes =
      volume::VersionChanges::encode(link.is_first ? *uncut_ : *tail_.version, *version);
  if (link.is_first) chain_bytes_ = 0, first_bytes_ = bytes.size();
  chain_bytes_ += bytes.size();
  put_link(link, bytes);
  tail_.version = version;
  return link.number;
}

void CheckpointEncoder::put_offsets(std::string& out, const std::shared_ptr<const haptics::TouchScene>& scene,
                                    const OffsetFields& offsets) {
  put_count(out, offsets.size());
  for (std::size_t s = 0; s < offsets.size(); ++s) {
    Chain& chain = chains_[{scene, s}];
    if (chain.id == 0) chain.id = tail_.next_chain++;
    if (chain.newest != offsets[s]) {
      const ChainLink link{
          chain.id, chain.next_link++,
          !chain.newest || chain.bytes > std::max(k_short_chain, k_longest_chain * chain.first_bytes)};
      const std::string bytes =
          volume::OffsetChanges::encode(link.is_first ? *scene->items[s].offset : *chain.newest, *offsets[s]);
      if (link.is_first) chain.bytes = 0, chain.first_bytes = bytes.size();
      chain.bytes += bytes.size();
      put_link(link, bytes);
      chain.newest = offsets[s];
      chain.newest_link = link.number;
    }
    put_count(out, chain.id);
    put_count(out, chain.newest_link);
  }
}

void CheckpointEncoder::put_fields(std::string& out, const Checkpoint& checkpoint,
                                   const std::shared_ptr<const haptics::TouchScene>& scene,
                                   const TouchFields::Kept& kept) {
  const std::size_t hand = hand_of(checkpoint, scene);
  put_count(out, hand);
  put_count(out, checkpoint.snapshot.hands[hand].tool.change_count);
  put_box(out, kept.stale_box);
  put_offsets(out, scene, kept.fields);
}

namespace {
void put_implant(std::string& out, const Body& body) {
  put(out, static_cast<std::uint8_t>(body.matter));
  put(out, static_cast<std::uint8_t>(body.is_fixed));
  put_placement(out, body.motion.from);
  put_count(out, body.motion.begin_tick);
  put(out, body.motion.seconds);
  put(out, body.motion.turns);
  put(out, body.motion.axis);
}
void put_position(std::string& out, const ProcedurePosition& position) {
  put_number(out, position.step);
  put_count(out, position.entered_tick);
  put_count(out, position.first_event);
  for (const std::uint32_t count : position.visits) put_count(out, count);
}
}  // namespace

void CheckpointEncoder::put_undoable(std::string& out, const UndoableState& undoable) {
  put_count(out, link_of(undoable.version));
  put_modules(out, undoable.modules);
  put_count(out, undoable.bodies.size());
  for (const Body& body : undoable.bodies) {
    std::uint64_t& chain = pieces_[body.id.value];
    if (chain == 0) {
      chain = tail_.next_chain++;
      put_link({chain, 0, true}, to_bytes(*body.piece));
    }
    put_count(out, body.id.value);
    put_number(out, body.mover);
    put_count(out, chain);
    put_placement(out, body.placement);
    put_number(out, body.holder);
    if (body.holder >= 0) put_placement(out, body.grip);
    put(out, static_cast<std::uint8_t>(body.is_implant));
    if (body.is_implant) put_implant(out, body);
  }
  if (undoable.procedure.step >= 0) put_position(out, undoable.procedure);
}

void CheckpointEncoder::put_entry_state(std::string& out, const Checkpoint& checkpoint,
                                        const EntryState& state) {
  put_undoable(out, state.undoable);
  const auto is_of_a_hand = [&](const auto& one) {
    return hand_of(checkpoint, one.first) < checkpoint.snapshot.hands.size();
  };
  put_count(
      out, static_cast<std::uint64_t>(std::count_if(state.fields.begin(), state.fields.end(), is_of_a_hand)));
  for (const auto& one : state.fields)
    if (is_of_a_hand(one)) put_fields(out, checkpoint, one.first, one.second);
}

void CheckpointEncoder::put_state(std::string& out, const OperationState& state) {
  put(out, state.next_tick);
  put_count(out, state.edits);
  put_undoable(out, state.undoable);
  put_modules(out, state.settings.modules);
  put_count(out, state.settings.results.size());
  for (const ModuleResult& result : state.settings.results) {
    put_bytes_of(out, result.value.get());
    put_count(out, result.edits);
  }
  for (const Instrument& hand : state.settings.hands) {
    put_text(out, hand.name());
    put_bytes_of(out, &hand.parameters);
    put_bytes_of(out, &hand.state);
  }
  put_count(out, state.settings.latest_commands.size());
  for (const auto& [key, command] : state.settings.latest_commands) {
    put_text(out, key);
    put(out, command.hand);
    put_value(out, command.request);
  }
  put_count(out, state.chronicle.size());
  put_count(out, state.chronicle.undos);
  put_count(out, state.chronicle.redos);
  for (const ForbiddenWatch& watch : state.watches) {
    std::string fields;
    encode_fields(ForbiddenWatch::schema(), &watch, fields);
    put_text(out, fields);
  }
}

void CheckpointEncoder::put_image(std::string& out, const Checkpoint& checkpoint) {
  const EngineSnapshot& snapshot = checkpoint.snapshot;
  for (const EngineSnapshot::Hand& hand : snapshot.hands) put_hand(out, hand);
  put_count(out, snapshot.other_branches.size());
  for_branches(snapshot, [&](const Branch& branch) {
    put_text(out, branch.name);
    put_count(out, branch.history.size());
    std::uint64_t last = 0;
    // Writes differences, since most numbers are consecutive. A difference may be negative: an entry whose
    // fields were adopted later is replaced, and has a larger number than the next entries.
    for (const auto& entry : branch.history)
      put_number(out, static_cast<std::int64_t>(entry->number - std::exchange(last, entry->number)));
    put_count(out, branch.position);
    put_count(out, branch.final_strokes);
  });
  put_numbers(out, snapshot);

  put_count(out, snapshot.jobs.size());
  for (const PendingJob& job : snapshot.jobs) {
    put_job(out, job);
    put_state(out, *job.input);
  }
  put(out, snapshot.serial);
  put_state(out, snapshot.state);

  put_count(out, snapshot.fields.size());
  for (const TouchFields& fields : snapshot.fields) {
    put_fields(out, checkpoint, fields.scene(), {fields.newest(), fields.stale_box()});
    put_cuts(out, fields);
  }
  put_count(out, checkpoint.fields.size());
  for (const Checkpoint::Fields& result : checkpoint.fields) {
    put(out, result.serial);
    put(out, result.hand);
    put_offsets(out, snapshot.hands[result.hand].tool.scene, result.offsets);
  }
}

/// Writes the new entries of the history with their states.
void CheckpointEncoder::put_history(std::string& out, const Checkpoint& checkpoint) {
  std::set<std::uint64_t> written_entries;  // branches share entries
  for_branches(checkpoint.snapshot, [&](const Branch& branch) {
    for (const auto& entry : branch.history) {
      if (entry->number <= tail_.last_entry || !written_entries.insert(entry->number).second) continue;
      const Result<EntryState> entry_state = entry->state();
      if (!entry_state) continue;  // unreadable, as its session was closed: a reader cannot restore it
      std::string bytes;
      put_entry_state(bytes, checkpoint, entry_state.value());
      put_count(out, entry->number);
      put_box(out, entry->box);
      put_text(out, bytes);
    }
  });
  tail_.last_entry = checkpoint.snapshot.last_entry;
}

std::string CheckpointEncoder::encode(const Checkpoint& checkpoint) {
  links_.clear();
  link_count_ = 0;
  // Drops the chains of scenes that no hand has any more: a new tool always gets a new scene.
  std::erase_if(chains_, [&](const auto& chain) {
    return hand_of(checkpoint, chain.first.first) == checkpoint.snapshot.hands.size();
  });
  // Encodes the parts before the links are written: encoding adds the links, which precede the parts.
  std::string events, trails, history, rest;
  put_history(history, checkpoint);
  const Chronicle& chronicle = checkpoint.snapshot.state.chronicle;
  put_count(events, tail_.events);
  put_count(events, chronicle.size() - tail_.events);
  for (std::size_t i = tail_.events; i < chronicle.size(); ++i) {
    const Event& event = chronicle[i];
    put(events, event.tick);
    put(events, event.hand);
    put(events, event.position_world);
    put_value(events, event.value);
  }
  tail_.events = chronicle.size();
  tail_.trail_counts.resize(checkpoint.snapshot.hands.size());
  for (std::size_t h = 0; h < checkpoint.snapshot.hands.size(); ++h) {
    const HandTrail& trail = checkpoint.snapshot.hands[h].trail;
    const std::size_t from = std::max<std::size_t>(tail_.trail_counts[h], trail.first());
    put_count(trails, trail.first());
    put_count(trails, from);
    put_count(trails, trail.count() - from);
    for (std::size_t i = from; i < trail.count(); ++i) put(trails, trail.position(i));
    tail_.trail_counts[h] = trail.count();
  }
  for (const std::string& core : checkpoint.cores) put_text(rest, core);
  put_count(rest, checkpoint.records.size());
  for (const haptics::ServoRecord& record : checkpoint.records) haptics::put_record(rest, record);
  put_image(rest, checkpoint);

  std::string out;
  put(out, checkpoint.block);
  put(out, checkpoint.next_tick);
  put_count(out, link_count_);
  out += links_;
  for (const std::string& part : {events, trails, history, rest}) put_text(out, compress(part));
  return out;
}

std::string bytes_without_state(const EngineSnapshot& snapshot) {
  std::string out;
  for (const EngineSnapshot::Hand& hand : snapshot.hands) {
    put_hand(out, hand);
    put_count(out, hand.trail.count());
    for (std::size_t i = hand.trail.first(); i < hand.trail.count(); ++i) put(out, hand.trail.position(i));
  }
  for (const TouchFields& fields : snapshot.fields) {
    put_box(out, fields.stale_box());
    put_cuts(out, fields);
  }
  for_branches(snapshot, [&](const Branch& branch) {
    put_text(out, branch.name);
    put_count(out, branch.position);
    put_count(out, branch.final_strokes);
    for (const auto& entry : branch.history) {
      put_count(out, entry->number);
      put_box(out, entry->box);
    }
  });
  put(out, snapshot.serial);
  put_numbers(out, snapshot);
  for (const PendingJob& job : snapshot.jobs) {
    put_job(out, job);
    put(out, job.input->hash());
  }
  return out;
}

bool read_index(std::string_view bytes, CheckpointIndex& index) {
  const char* begin = bytes.data();
  const auto part = [&](CheckpointIndex::Part& position) {
    std::string_view text;
    if (!get_text(bytes, text)) return false;
    position = {static_cast<std::uint64_t>(text.data() - begin), text.size()};
    return true;
  };
  std::int64_t links = 0;
  if (!get(bytes, index.block) || !get(bytes, index.next_tick) || !get_number(bytes, links)) return false;
  for (; links > 0; --links) {
    CheckpointIndex::Link link;
    std::int64_t chain = 0, number = 0;
    std::uint8_t is_first = 0;
    if (!get_number(bytes, chain) || !get_number(bytes, number) || !get(bytes, is_first)) return false;
    if (chain < 0 || number < 0 || !part(link.bytes)) return false;
    link.chain = static_cast<std::uint64_t>(chain);
    link.number = static_cast<std::uint64_t>(number);
    link.is_first = is_first != 0;
    index.links.push_back(link);
  }
  return links == 0 && part(index.events) && part(index.trails) && part(index.history) && part(index.rest) &&
         bytes.empty();
}

}  // namespace trephine::sim
