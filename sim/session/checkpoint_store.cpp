// CheckpointStore: decodes checkpoints, in the order in which checkpoint_format.cpp encodes their fields.
// Kept in one file, so that the order of the fields can be compared with that of the encoder.
#include "sim/session/checkpoint_store.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <new>
#include <utility>

#include "sim/engine/tool_geometry.h"
#include "sim/session/checkpoint_bytes.h"
#include "volume/cuts/version_changes.h"
#include "volume/fields/offset_changes.h"

namespace trephine::sim {

struct CheckpointStore::Shared : std::enable_shared_from_this<Shared> {
  Shared(SessionReader& reader, Engine from) : session(&reader), life(reader.life()), start(std::move(from)) {
    for (const CheckpointIndex& index : reader.checkpoints())
      for (const CheckpointIndex::Link& link : index.links) links[{link.chain, link.number}] = &link;
  }

  SessionReader* session;
  std::weak_ptr<const bool> life;  ///< of the reader, which an engine may outlive
  Engine start;
  std::map<std::pair<std::uint64_t, std::uint64_t>, const CheckpointIndex::Link*> links;

  // Version and fields that were decoded last: later links of a chain are applied to them.
  std::uint64_t version_link = 0;
  std::shared_ptr<const volume::Version> version;
  struct LastField {
    std::uint64_t link = 0;
    std::shared_ptr<const haptics::TouchScene> scene;
    std::shared_ptr<const volume::OffsetField> field;
  };
  std::map<std::uint64_t, LastField> fields;
  std::map<std::pair<std::size_t, std::string>, std::shared_ptr<const PreparedTool>> geometries;
  std::vector<Event> events;  ///< of the first `event_checkpoints` checkpoints
  std::size_t event_checkpoints = 0;
  bool are_events_known = true;
  struct StoredEntry {
    volume::VoxelBox box;
    std::string bytes;
  };
  std::map<std::uint64_t, std::shared_ptr<const Piece>> pieces;  ///< by chain
  std::map<std::uint64_t, StoredEntry> entries;  ///< of the first `entry_checkpoints` checkpoints
  std::size_t entry_checkpoints = 0;

  /// Returns the bytes of the links of a chain up to link `number`, oldest first. The first returned link is
  /// the later of two: the link after `known`, or the newest link that needs no link before it.
  /// `starts_after_known`: set to whether it depends on the link `known`.
  std::vector<std::string> links_to(std::uint64_t chain, std::uint64_t number, std::uint64_t known,
                                    bool& starts_after_known) {
    std::vector<std::string> result;
    std::size_t bytes = 0;
    constexpr std::size_t k_max_bytes = std::size_t{1} << 30;
    starts_after_known = false;
    for (std::uint64_t n = number;; --n) {
      const auto found = links.find({chain, n});
      if (found == links.end()) throw Broken{"a missing state"};
      result.push_back(value_or_throw(session->read(found->second->bytes)));
      if ((bytes += result.back().size()) > k_max_bytes) throw Broken{"a chain that is too long"};
      if (found->second->is_first) break;
      if (n == 0) throw Broken{"a chain without a beginning"};
      if ((starts_after_known = n - 1 == known)) break;
    }
    std::reverse(result.begin(), result.end());
    return result;
  }
  static std::vector<std::string_view> views(const std::vector<std::string>& all) {
    return {all.begin(), all.end()};
  }

  std::shared_ptr<const volume::Version> version_at(std::uint64_t link) {
    if (version && version_link == link) return version;
    bool starts_after_known = false;
    const auto changes = links_to(0, link, version ? version_link : ~std::uint64_t{0}, starts_after_known);
    version = value_or_throw(volume::VersionChanges::apply(
        starts_after_known ? *version : *start.state().undoable.version, views(changes)));
    version_link = link;
    return version;
  }
  std::shared_ptr<const volume::OffsetField> field_at(std::uint64_t chain, std::uint64_t link,
                                                      const std::shared_ptr<const haptics::TouchScene>& scene,
                                                      std::size_t shape) {
    LastField& last = fields[chain];
    const bool is_same = last.field && last.scene == scene;
    if (is_same && last.link == link) return last.field;
    const std::shared_ptr<const volume::OffsetField>& uncut = scene->items[shape].offset;
    if (!uncut) throw Broken{"an offset field without a round tool"};
    bool starts_after_known = false;
    const auto changes = links_to(chain, link, is_same ? last.link : ~std::uint64_t{0}, starts_after_known);
    last.field = value_or_throw(
        volume::OffsetChanges::apply(starts_after_known ? *last.field : *uncut, views(changes)));
    last.link = link;
    last.scene = scene;
    return last.field;
  }

  /// Reads values of the types of `initial`. The recording engine may have had fewer modules: the first of
  /// these.
  std::vector<std::shared_ptr<const Value>> read_modules(
      ByteReader& in, const std::vector<std::shared_ptr<const Value>>& initial) {
    std::vector<std::shared_ptr<const Value>> modules = initial;
    const std::uint64_t count = in.count(initial.size());
    for (std::uint64_t m = 0; m < count; ++m) {
      const std::string_view bytes = in.text();
      if (initial[m])
        modules[m] =
            std::make_shared<const Value>(value_or_throw(Value::from_bytes(initial[m]->type(), bytes)));
    }
    return modules;
  }
  Value read_value(ByteReader& in) {
    const std::string_view name = in.text(), bytes = in.text();
    if (name.empty()) return {};
    const ValueType* type = session->catalogue().find(name);
    if (type == nullptr) throw Broken{"a value of an unknown type"};
    return value_or_throw(Value::from_bytes(*type, bytes));
  }

  const std::vector<Event>& events_up_to(std::size_t i) {
    for (; event_checkpoints <= i; ++event_checkpoints) {
      are_events_known = true;
      try {
        read_events(value_or_throw(session->read(session->checkpoints()[event_checkpoints].events)));
      } catch (const Broken&) {
        are_events_known = false;  // until a later checkpoint stores the missing events
      }
    }
    if (!are_events_known) throw Broken{"missing events"};
    return events;
  }
  void read_events(const std::string& bytes) {
    ByteReader in(bytes);
    const std::uint64_t from = in.count();
    if (from > events.size()) throw Broken{"missing events"};
    events.resize(from);
    for (std::uint64_t remaining = in.element_count(); remaining > 0; --remaining) {
      Event event;
      event.tick = in.value<std::uint64_t>();
      event.hand = in.value<std::uint8_t>();
      event.position_world = in.position();
      event.value = read_value(in);
      if (event.value.is_empty()) throw Broken{"an event without a name"};
      events.push_back(std::move(event));
    }
  }
  const std::map<std::uint64_t, StoredEntry>& entries_up_to(std::size_t i) {
    for (; entry_checkpoints <= i; ++entry_checkpoints) {
      try {
        const std::string bytes =
            value_or_throw(session->read(session->checkpoints()[entry_checkpoints].history));
        ByteReader in(bytes);
        while (!in.is_at_end()) {
          const std::uint64_t number = in.count();
          const volume::VoxelBox box = in.box(start.scene().base->size);
          entries.insert_or_assign(number, StoredEntry{box, std::string(in.text())});
        }
      } catch (const Broken&) {
        continue;  // read_entry() reports an error if one of these entries is needed
      }
    }
    return entries;
  }
  /// Reads this checkpoint and earlier ones, until the trails are complete.
  std::vector<HandTrail> trails_at(std::size_t i) {
    struct Part {
      std::uint64_t first = 0, from = 0;
      std::vector<glm::dvec3> places;
    };
    std::vector<Part> parts(start.hand_count());
    for (std::size_t k = i;; --k) {
      const std::string bytes = value_or_throw(session->read(session->checkpoints()[k].trails));
      ByteReader in(bytes);
      bool is_whole = true;
      for (Part& part : parts) {
        const std::uint64_t first = in.count(), from = in.count(), count = in.element_count();
        std::vector<glm::dvec3> places;
        for (std::uint64_t n = 0; n < count; ++n) places.push_back(in.position());
        if (k == i) {
          part = {first, from, std::move(places)};
        } else if (part.from > part.first) {
          if (from + count != part.from) throw Broken{"a trail with a gap"};
          places.insert(places.end(), part.places.begin(), part.places.end());
          part.from = from;
          part.places = std::move(places);
        }
        is_whole = is_whole && part.from <= part.first;
      }
      if (is_whole) break;
      if (k == 0) throw Broken{"a trail without a beginning"};
    }
    std::vector<HandTrail> trails;
    for (const Part& part : parts) {
      if (part.first - part.from > part.places.size()) throw Broken{"an invalid trail"};
      trails.push_back(HandTrail::of(part.first, std::span(part.places).subspan(part.first - part.from)));
    }
    return trails;
  }

  // ---- parts of a snapshot ----

  struct Hands {
    std::vector<std::shared_ptr<const haptics::TouchScene>> scenes;
    std::vector<std::uint64_t> tool_numbers;
  };
  /// Reads the offset fields of `scene`. If `scene` is null, skips their bytes and returns null fields.
  OffsetFields read_offsets(ByteReader& in, const std::shared_ptr<const haptics::TouchScene>& scene) {
    OffsetFields offsets(in.count(haptics::ShapeSet::k_max));
    if (scene && !offsets.empty() && offsets.size() != haptics::base_shapes(*scene).size())
      throw Broken{"different numbers of offset fields and shapes"};
    for (std::size_t s = 0; s < offsets.size(); ++s) {
      const std::uint64_t chain = in.count(), link = in.count();
      if (scene) offsets[s] = field_at(chain, link, scene, s);
    }
    return offsets;
  }
  /// Returns the scene of a hand after its first `tool_number` tool changes; null if no hand still has that
  /// scene.
  std::shared_ptr<const haptics::TouchScene> scene_of(std::size_t hand, std::uint64_t tool_number,
                                                      const Hands& hands) const {
    if (hands.tool_numbers[hand] == tool_number) return hands.scenes[hand];
    const auto& first = start.servo_scene()->hands;
    for (std::size_t h = 0; tool_number == 0 && h < hands.scenes.size(); ++h)
      if (hands.tool_numbers[h] == 0 && first[h].scene == first[hand].scene) return hands.scenes[h];
    return nullptr;
  }
  std::pair<std::shared_ptr<const haptics::TouchScene>, TouchFields::Kept> read_fields(ByteReader& in,
                                                                                       const Hands& hands) {
    const std::uint64_t hand = in.count(hands.scenes.size() - 1), tool_number = in.count();
    const auto scene = scene_of(hand, tool_number, hands);
    const volume::VoxelBox stale_box = in.box(start.scene().base->size);
    return {scene, {read_offsets(in, scene), stale_box}};
  }
  void read_implant(ByteReader& in, Body& body) {
    body.is_implant = true;
    const auto matter = in.value<std::uint8_t>();
    if (matter >= std::size(volume::k_matters)) throw Broken{"an implant of unknown matter"};
    body.matter = static_cast<volume::Matter>(matter);
    body.is_fixed = in.value<std::uint8_t>() != 0;
    body.motion.from = in.placement();
    body.motion.begin_tick = in.count();
    body.motion.seconds = in.value<double>();
    body.motion.turns = in.value<double>();
    body.motion.axis = in.value<glm::dvec3>();
    const double length = glm::length(body.motion.axis);
    if (!(body.motion.seconds >= 0 && body.motion.seconds <= 1e4) || !(std::abs(body.motion.turns) <= 1e4) ||
        !(std::abs(length - 1) < 1e-6))
      throw Broken{"an implant with an invalid motion"};
  }
  UndoableState read_undoable(ByteReader& in) {
    UndoableState undoable;
    undoable.version = version_at(in.count());
    undoable.modules = read_modules(in, start.state().undoable.modules);
    for (std::uint64_t remaining = in.count(haptics::ShapeSet::k_max); remaining > 0; --remaining) {
      Body body;
      body.id.value = static_cast<std::uint32_t>(in.count(~std::uint32_t{0}));
      const std::int64_t mover = in.signed_number();
      if (mover < -1 || mover >= haptics::TouchScene::k_max_movers)
        throw Broken{"a body with an unknown mover"};
      body.mover = static_cast<int>(mover);
      const std::uint64_t chain = in.count();
      std::shared_ptr<const Piece>& piece = pieces[chain];
      bool starts_after_known = false;
      if (!piece) piece = piece_from_bytes(links_to(chain, 0, ~std::uint64_t{0}, starts_after_known).back());
      if (!piece) throw Broken{"an invalid piece"};
      body.piece = piece;
      body.placement = in.placement();
      const std::int64_t holder = in.signed_number();
      if (holder < -1 || holder >= static_cast<std::int64_t>(start.hand_count()))
        throw Broken{"a body in an unknown hand"};
      body.holder = static_cast<int>(holder);
      if (holder >= 0) body.grip = in.placement();
      if (in.value<std::uint8_t>() != 0) read_implant(in, body);
      if (body.is_fixed != (body.mover < 0) || (body.is_fixed && holder >= 0))
        throw Broken{"a fixed body in motion"};
      const auto is_used = [&](const auto& item) { return body.mover >= 0 && item.mover == body.mover; };
      bool is_valid = std::none_of(undoable.bodies.begin(), undoable.bodies.end(), is_used) &&
                      (undoable.bodies.empty() || undoable.bodies.back().id.value < body.id.value);
      for (std::size_t h = 0; h < start.hand_count(); ++h)
        is_valid =
            is_valid && std::none_of(start.scene(h).items.begin(), start.scene(h).items.end(), is_used);
      if (!is_valid) throw Broken{"two bodies with the same id or mover"};
      undoable.bodies.push_back(std::move(body));
    }
    if (start.state().undoable.procedure.step >= 0) read_position(in, undoable.procedure);
    return undoable;
  }
  void read_position(ByteReader& in, ProcedurePosition& position) const {
    const std::size_t steps = start.state().undoable.procedure.visits.size();
    position.step = static_cast<std::int32_t>(in.count(steps - 1));
    position.entered_tick = in.count();
    position.first_event = in.count();
    for (std::size_t s = 0; s < steps; ++s)
      position.visits.push_back(static_cast<std::uint32_t>(in.count(~std::uint32_t{0})));
  }
  EntryState read_entry_state(ByteReader& in, const Hands& hands) {
    EntryState state;
    state.undoable = read_undoable(in);
    for (std::uint64_t remaining = in.count(haptics::ServoScene::k_max_hands); remaining > 0; --remaining)
      if (auto fields = read_fields(in, hands); fields.first) state.fields.push_back(std::move(fields));
    return state;
  }
  OperationState read_state(ByteReader& in, const std::vector<Event>& all_events) {
    const OperationState& initial = start.state();
    OperationState state;
    state.next_tick = in.value<std::uint64_t>();
    state.edits = in.count();
    state.dt = initial.dt, state.plan = initial.plan;
    state.undoable = read_undoable(in);
    state.settings.modules = read_modules(in, initial.settings.modules);
    state.settings.results = initial.settings.results;
    const std::uint64_t results = in.count(initial.settings.results.size());
    for (std::uint64_t m = 0; m < results; ++m) {
      ModuleResult& result = state.settings.results[m];
      const std::string_view bytes = in.text();
      result.edits = in.count();
      if (result.value)
        result.value =
            std::make_shared<const Value>(value_or_throw(Value::from_bytes(result.value->type(), bytes)));
    }
    for (std::size_t h = 0; h < start.hand_count(); ++h) {
      const std::string_view name = in.text(), parameters = in.text(), memory = in.text();
      Instrument& hand = state.settings.hands.emplace_back();
      if (name.empty()) continue;
      hand.type = session->catalogue().find_instrument(name);
      if (hand.type == nullptr) throw Broken{"an instrument that this program does not have"};
      hand.parameters = value_or_throw(Value::from_bytes(*hand.type->parameters, parameters));
      hand.state = value_or_throw(Value::from_bytes(*hand.type->state, memory));
    }
    for (std::uint64_t remaining = in.element_count(); remaining > 0; --remaining) {
      std::string key(in.text());
      Command command;
      command.hand = in.value<std::uint8_t>();
      command.request = read_value(in);
      if (command.request.is_empty() || command.hand >= start.hand_count())
        throw Broken{"an invalid command"};
      state.settings.latest_commands.emplace(std::move(key), std::move(command));
    }
    const std::uint64_t count = in.count(all_events.size());
    for (std::uint64_t i = 0; i < count; ++i) state.chronicle.add(all_events[i]);
    state.chronicle.undos = in.count();
    state.chronicle.redos = in.count();
    for (std::size_t w = 0; w < initial.watches.size(); ++w)
      if (decode_fields(ForbiddenWatch::schema(), &state.watches.emplace_back(), in.text()))
        throw Broken{"invalid values of a forbidden structure"};
    return state;
  }
  /// Reads a hand, with its initial tool or another one.
  void read_hand(ByteReader& in, std::size_t h, EngineSnapshot::Hand& hand) {
    ToolGeometry geometry{in.number(), {}, {}, 0};
    for (std::uint64_t remaining = in.count(haptics::ToolShape::k_max_balls); remaining > 0; --remaining)
      geometry.balls.push_back(in.position());
    for (std::uint64_t remaining = in.count(2 * haptics::ToolProfile::k_max_rings); remaining > 0;
         --remaining)
      geometry.profile.push_back(in.number());
    geometry.spacing = in.number();
    hand.tool = start.tool(h);
    hand.tool.change_count = in.count();
    const haptics::SharedTool initial = hand.tool.scene->tool;
    const bool has_mesh = geometry.spacing == k_spacing_of_model;
    if (has_mesh && !initial->mesh()) throw Broken{"a tool of an unknown mesh"};
    if (hand.tool.change_count != 0) {
      std::shared_ptr<const PreparedTool>& prepared =
          geometries[{h, has_mesh ? "mesh" : Value(geometry).bytes()}];
      if (!prepared) {
        if (check_tool_radius(*hand.tool.scene->base, geometry.radius)) throw Broken{"an invalid tool"};
        prepared = make_geometry(hand.tool, has_mesh ? Result(initial) : geometry.tool(),
                                 *start.state().undoable.version, k_no_voxels);
      }
      if (prepared->failed) throw Broken{"a tool of invalid geometry"};
      hand.tool.scene = prepared->scene;
      hand.tool.method = prepared->method;
    }
    if (in.flags(1) != 0) {
      auto path = std::make_shared<haptics::EscapePath>();
      path->serial = in.value<std::uint64_t>();
      path->count = static_cast<std::uint32_t>(in.count(haptics::EscapePath::k_max_positions));
      for (std::uint32_t i = 0; i < path->count; ++i) path->positions_volume[i] = in.position();
      hand.escape_path = std::move(path);
    }
    const auto flags = in.flags(15);
    hand.work.is_pressed = flags & 1;
    hand.work.is_fresh = flags & 2;
    hand.work.noted_faults = in.value<std::uint32_t>();
    if (flags & 4) {
      const glm::dvec3 centre = in.position();
      hand.work.instrument_ball = ToolBall{centre, in.number()};
    }
    if (flags & 8) hand.work.placement = in.placement();
  }

  void read_history(ByteReader& in, std::size_t i, const Hands& hands, EngineSnapshot& snapshot) {
    const auto& stored = entries_up_to(i);
    std::map<std::uint64_t, std::shared_ptr<const HistoryEntry>> entries_read;  // branches share entries
    const std::uint64_t others = in.count(Engine::k_max_branches - 1);
    snapshot.branch = read_branch(in, hands, stored, entries_read);
    for (std::uint64_t remaining = others; remaining > 0; --remaining)
      snapshot.other_branches.push_back(read_branch(in, hands, stored, entries_read));
    snapshot.last_entry = in.count();
    snapshot.addition_count = in.count();
    snapshot.last_job = static_cast<std::uint32_t>(in.count(~std::uint32_t{0}));
    snapshot.last_body = static_cast<std::uint32_t>(in.count(~std::uint32_t{0}));
  }

  Branch read_branch(ByteReader& in, const Hands& hands, const std::map<std::uint64_t, StoredEntry>& stored,
                     std::map<std::uint64_t, std::shared_ptr<const HistoryEntry>>& entries_read) {
    Branch branch;
    branch.name = in.text();
    std::uint64_t number = 0;
    for (std::uint64_t remaining = in.count(Engine::k_max_strokes + 1); remaining > 0; --remaining) {
      number += static_cast<std::uint64_t>(in.signed_number());
      std::shared_ptr<const HistoryEntry>& entry = entries_read[number];
      if (!entry) entry = read_entry(number, hands, stored);
      branch.history.push_back(entry);
    }
    branch.position = in.count();
    branch.final_strokes = in.count();
    if (branch.position >= branch.history.size()) throw Broken{"an invalid history entry"};
    return branch;
  }

  std::shared_ptr<const HistoryEntry> read_entry(std::uint64_t number, const Hands& hands,
                                                 const std::map<std::uint64_t, StoredEntry>& stored) {
    const auto found = stored.find(number);
    if (found == stored.end()) throw Broken{"a missing history entry"};
    HistoryEntry entry{number, found->second.box, {}, {}};
    entry.load = [shared = shared_from_this(), hands, bytes = found->second.bytes,
                  loaded = std::make_shared<std::optional<EntryState>>()]() -> Result<EntryState> {
      try {
        if (*loaded) return **loaded;
        if (shared->life.expired())
          return Error{.what = "the earlier history can no longer be read",
                       .expected = "a session that stays open while it is continued",
                       .remedy = "open the session again"};
        ByteReader reader(bytes);
        return *(*loaded = shared->read_entry_state(reader, hands));
      } catch (const Broken& broken) {
        return error_of(broken);
      } catch (const std::bad_alloc&) {
        return error_of({"more data than fit in memory"});
      }
    };
    return std::make_shared<const HistoryEntry>(std::move(entry));
  }

  void read_jobs(ByteReader& in, const std::vector<Event>& all_events, EngineSnapshot& snapshot) {
    for (std::uint64_t remaining = in.element_count(); remaining > 0; --remaining) {
      PendingJob job;
      job.id.value = static_cast<std::uint32_t>(in.count(~std::uint32_t{0}));
      job.hand = in.value<std::uint8_t>();
      job.parameters = std::make_shared<const Value>(read_value(in));
      job.addition_count = in.count();
      job.cut = in.box(start.scene().base->size);
      job.input = std::make_shared<const OperationState>(read_state(in, all_events));
      if (job.hand >= start.hand_count() || job.parameters->is_empty()) throw Broken{"an invalid job"};
      if (!job.parameters->as<ToolGeometry>() && !job.parameters->as<TakeInstrument>() &&
          !job.parameters->as<FreePieces>() && !start.find_job(job.parameters->type(), job.type, job.module))
        throw Broken{"a job that this program does not have"};
      const haptics::TouchScene& anatomy = *start.tool(job.hand).scene;
      const auto* pieces = job.parameters->as<FreePieces>();
      if ((pieces && check_shape_of_pieces(anatomy, pieces->item, "")) ||
          (job.type && job.type->check && job.type->check(job.parameters->data(), anatomy)) ||
          (job.parameters->as<TakeInstrument>() &&
           !start.named_instrument(*job.parameters->as<TakeInstrument>())))
        throw Broken{"a job of another anatomy"};
      snapshot.jobs.push_back(std::move(job));
    }
  }

  Checkpoint read_checkpoint(std::size_t i) {
    const CheckpointIndex& index = session->checkpoints()[i];
    const std::string bytes = value_or_throw(session->read(index.rest));
    const std::vector<Event>& all_events = events_up_to(i);
    std::vector<HandTrail> trails = trails_at(i);
    Checkpoint result;
    result.block = index.block;
    result.next_tick = index.next_tick;
    ByteReader in(bytes);
    const std::size_t count = start.hand_count();
    for (std::size_t h = 0; h < count; ++h) result.cores.emplace_back(in.text());
    for (std::uint64_t remaining = in.count(CheckpointMaker::k_max_records); remaining > 0; --remaining) {
      result.records.push_back(in.record());
      if (result.records.back().hand >= count) throw Broken{"a tick of an unknown hand"};
    }
    EngineSnapshot& snapshot = result.snapshot;
    snapshot.hands.resize(count);
    Hands hands;
    for (std::size_t h = 0; h < count; ++h) {
      read_hand(in, h, snapshot.hands[h]);
      snapshot.hands[h].trail = std::move(trails[h]);
      hands.scenes.push_back(snapshot.hands[h].tool.scene);
      hands.tool_numbers.push_back(snapshot.hands[h].tool.change_count);
    }
    read_history(in, i, hands, snapshot);
    snapshot.is_stroke_changed = in.flags(1) != 0;
    snapshot.stroke_box = in.box(start.scene().base->size);
    snapshot.all_cuts_box = in.box(start.scene().base->size);
    read_jobs(in, all_events, snapshot);
    snapshot.serial = in.value<std::uint64_t>();
    snapshot.state = read_state(in, all_events);
    for (std::uint64_t remaining = in.count(count); remaining > 0; --remaining) {
      auto [scene, kept] = read_fields(in, hands);
      const bool is_twice = std::any_of(snapshot.fields.begin(), snapshot.fields.end(),
                                        [&, s = scene](const TouchFields& f) { return f.scene() == s; });
      if (!scene || is_twice || !(scene->tool->radius() > 0))
        throw Broken{"offset fields of an unknown tool"};
      std::vector<std::pair<std::uint64_t, volume::VoxelBox>> cuts(in.element_count());
      for (auto& [serial, box] : cuts) {
        serial = in.value<std::uint64_t>();
        box = in.box(scene->base->size);
      }
      snapshot.fields.push_back(
          TouchFields::of(scene, std::move(kept), cuts, snapshot.state.undoable.version));
    }
    for (std::uint64_t remaining = in.element_count(); remaining > 0; --remaining) {
      Checkpoint::Fields& output = result.fields.emplace_back();
      output.serial = in.value<std::uint64_t>();
      output.hand = in.value<std::uint8_t>();
      if (output.hand >= count) throw Broken{"offset fields of an unknown hand"};
      output.offsets = read_offsets(in, hands.scenes[output.hand]);
    }
    if (!in.is_at_end()) throw Broken{"excess bytes"};
    return result;
  }

  static Error error_of(const Broken& broken) {
    return Error{.what = "a checkpoint of the session is damaged",
                 .found = broken.what,
                 .expected = "unchanged data written by trephine",
                 .remedy = "open the session from its start"};
  }
};

CheckpointStore::CheckpointStore(SessionReader& session, Engine start)
    : shared_(std::make_shared<Shared>(session, std::move(start))) {}
CheckpointStore::~CheckpointStore() = default;

std::size_t CheckpointStore::size() const noexcept { return shared_->session->checkpoints().size(); }
const CheckpointIndex& CheckpointStore::index(std::size_t i) const noexcept {
  return shared_->session->checkpoints()[i];
}

std::optional<std::size_t> CheckpointStore::before(std::uint64_t tick) const noexcept {
  const std::vector<CheckpointIndex>& all = shared_->session->checkpoints();
  const auto after = std::partition_point(
      all.begin(), all.end(), [tick](const CheckpointIndex& one) { return one.next_tick <= tick; });
  if (after == all.begin()) return std::nullopt;
  return static_cast<std::size_t>(after - all.begin()) - 1;
}

Result<Checkpoint> CheckpointStore::read(std::size_t i) {
  try {
    return shared_->read_checkpoint(i);
  } catch (const Broken& broken) {
    return Shared::error_of(broken);
  } catch (const std::bad_alloc&) {
    return Shared::error_of({"more data than fit in memory"});
  }
}

CheckpointTail CheckpointStore::tail() {
  CheckpointTail tail;
  for (const auto& [key, link] : shared_->links) {
    if (key.first == 0) tail.next_link = key.second + 1;
    tail.next_chain = std::max(tail.next_chain, key.first + 1);
  }
  if (size() == 0) return tail;
  const Result<Checkpoint> newest = read(size() - 1);
  if (!newest) return tail;
  const EngineSnapshot& snapshot = newest.value().snapshot;
  tail.version = snapshot.state.undoable.version;
  tail.last_entry = snapshot.last_entry;
  tail.events = snapshot.state.chronicle.size();
  for (const EngineSnapshot::Hand& hand : snapshot.hands) tail.trail_counts.push_back(hand.trail.count());
  return tail;
}

}  // namespace trephine::sim
