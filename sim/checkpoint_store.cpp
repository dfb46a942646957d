// One file: the parts of a checkpoint are written and read next to each other, field by field.
#include "sim/checkpoint_store.h"

#include <algorithm>
#include <cmath>
#include <new>
#include <utility>

#include "haptics/servo/servo_memory.h"
#include "sim/tool_geometry.h"
#include "volume/bytes.h"
#include "volume/offset_changes.h"
#include "volume/version_changes.h"

namespace trephine::sim {

using volume::Error;
using volume::get;
using volume::get_number;
using volume::get_text;
using volume::Result;
using volume::Status;

namespace {

/// Broken bytes: what was read for. Thrown within this file alone.
struct Broken {
  const char* what;
};

/// Takes value after value; throws at an invalid one.
class Taker {
 public:
  explicit Taker(std::string_view in) : in_(in) {}

  template <class T>
  T value() {
    T taken{};
    if (!get(in_, taken)) throw Broken{"it ends early"};
    return taken;
  }
  std::uint64_t count(std::uint64_t most = ~std::uint64_t{0}) {
    const std::int64_t taken = signed_number();
    if (taken < 0 || static_cast<std::uint64_t>(taken) > most) throw Broken{"a number out of its range"};
    return static_cast<std::uint64_t>(taken);
  }
  std::int64_t signed_number() {
    std::int64_t taken = 0;
    if (!get_number(in_, taken)) throw Broken{"it ends early"};
    return taken;
  }
  /// Count of things that take a byte each at least.
  std::uint64_t count_of_things() { return count(in_.size()); }
  std::string_view text() {
    std::string_view taken;
    if (!get_text(in_, taken)) throw Broken{"it ends early"};
    return taken;
  }
  double number() {
    const auto taken = value<double>();
    if (!(std::abs(taken) < 1e12)) throw Broken{"an invalid number"};
    return taken;
  }
  glm::dvec3 place() {
    const double x = number(), y = number(), z = number();
    return {x, y, z};
  }
  std::uint8_t flags(std::uint8_t known) {
    const auto taken = value<std::uint8_t>();
    if ((taken & ~known) != 0) throw Broken{"an unknown flag"};
    return taken;
  }
  haptics::Placement placement() {
    haptics::Placement taken;
    taken.position_world = place();
    double parts[4];
    for (double& part : parts) part = number();
    taken.rotation = {parts[0], parts[1], parts[2], parts[3]};
    if (!(std::abs(glm::length(taken.rotation) - 1) < 1e-6)) throw Broken{"an invalid rotation"};
    return taken;
  }
  volume::VoxelBox box(const glm::ivec3& size) {
    volume::VoxelBox taken;
    bool is_empty = false;
    for (glm::ivec3* corner : {&taken.low, &taken.high})
      for (int a = 0; a < 3; ++a) {
        const std::int64_t at = signed_number();
        if (std::abs(at) > (1 << 30)) throw Broken{"an invalid box"};
        (*corner)[a] = static_cast<int>(at);
      }
    for (int a = 0; a < 3; ++a) is_empty = is_empty || taken.low[a] > taken.high[a];
    for (int a = 0; !is_empty && a < 3; ++a)
      if (taken.low[a] < -64 || taken.high[a] > size[a] + 64) throw Broken{"a box beyond the volume"};
    return taken;
  }
  haptics::ServoRecord record() {
    haptics::ServoRecord taken;
    if (!haptics::get_record(in_, taken)) throw Broken{"an invalid tick"};
    return taken;
  }
  bool is_at_end() const { return in_.empty(); }

 private:
  std::string_view in_;
};

template <class T>
T good(Result<T> result) {
  if (!result) throw Broken{"invalid bricks or values"};
  return std::move(result).value();
}

}  // namespace

struct CheckpointStore::Shared : std::enable_shared_from_this<Shared> {
  Shared(SessionReader& reader, Engine from) : session(&reader), life(reader.life()), start(std::move(from)) {
    for (const CheckpointIndex& index : reader.checkpoints())
      for (const CheckpointIndex::Link& link : index.links) links[{link.chain, link.number}] = &link;
  }

  SessionReader* session;
  std::weak_ptr<const bool> life;  ///< of the reader: an engine may outlive it
  Engine start;
  std::map<std::pair<std::uint64_t, std::uint64_t>, const CheckpointIndex::Link*> links;

  // Last read position: from there on is the shorter way.
  std::uint64_t version_link = 0;
  std::shared_ptr<const volume::Version> version;
  struct LastField {
    std::uint64_t link = 0;
    std::shared_ptr<const haptics::TouchScene> scene;
    std::shared_ptr<const volume::OffsetField> field;
  };
  std::map<std::uint64_t, LastField> fields;
  std::map<std::pair<std::size_t, std::string>, std::shared_ptr<const MadeGeometry>> geometries;
  std::vector<Event> events;  ///< of the first `events_of` checkpoints
  std::size_t events_of = 0;
  bool are_events_known = true;
  struct KeptEntry {
    volume::VoxelBox box;
    std::string place;
  };
  std::map<std::uint64_t, std::shared_ptr<const Piece>> pieces;  ///< by chain
  std::map<std::uint64_t, KeptEntry> entries;  ///< of the histories of the first `entries_of` checkpoints
  std::size_t entries_of = 0;

  /// The bytes that lead to a link, oldest first: from the first of its chain, or from `known` on, if that is
  /// newer.
  std::vector<std::string> way_to(std::uint64_t chain, std::uint64_t number, std::uint64_t known,
                                  bool& is_on) {
    std::vector<std::string> all;
    std::size_t bytes = 0;
    constexpr std::size_t k_longest_way = std::size_t{1} << 30;
    is_on = false;
    for (std::uint64_t n = number;; --n) {
      const auto found = links.find({chain, n});
      if (found == links.end()) throw Broken{"a missing state"};
      all.push_back(good(session->read(found->second->bytes)));
      if ((bytes += all.back().size()) > k_longest_way) throw Broken{"a chain that is too long"};
      if (found->second->is_first) break;
      if (n == 0) throw Broken{"a chain without a beginning"};
      if ((is_on = n - 1 == known)) break;
    }
    std::reverse(all.begin(), all.end());
    return all;
  }
  static std::vector<std::string_view> views(const std::vector<std::string>& all) {
    return {all.begin(), all.end()};
  }

  std::shared_ptr<const volume::Version> version_at(std::uint64_t link) {
    if (version && version_link == link) return version;
    bool is_on = false;
    const auto way = way_to(0, link, version ? version_link : ~std::uint64_t{0}, is_on);
    version =
        good(volume::VersionChanges::applied(is_on ? *version : *start.now().world.version, views(way)));
    version_link = link;
    return version;
  }
  std::shared_ptr<const volume::OffsetField> field_at(std::uint64_t chain, std::uint64_t link,
                                                      const std::shared_ptr<const haptics::TouchScene>& scene,
                                                      std::size_t shape) {
    LastField& last = fields[chain];
    const bool is_same = last.field && last.scene == scene;
    if (is_same && last.link == link) return last.field;
    const std::shared_ptr<const volume::OffsetField>& untouched = scene->items[shape].offset;
    if (!untouched) throw Broken{"a tool's field without a tool"};
    bool is_on = false;
    const auto way = way_to(chain, link, is_same ? last.link : ~std::uint64_t{0}, is_on);
    last.field = good(volume::OffsetChanges::applied(is_on ? *last.field : *untouched, views(way)));
    last.link = link;
    last.scene = scene;
    return last.field;
  }

  /// As `like`, which is how they began; an engine may have gone without some of the last.
  std::vector<std::shared_ptr<const Value>> take_modules(
      Taker& in, const std::vector<std::shared_ptr<const Value>>& like) {
    std::vector<std::shared_ptr<const Value>> modules = like;
    const std::uint64_t count = in.count(like.size());
    for (std::uint64_t m = 0; m < count; ++m) {
      const std::string_view bytes = in.text();
      if (like[m])
        modules[m] = std::make_shared<const Value>(good(Value::from_bytes(like[m]->type(), bytes)));
    }
    return modules;
  }
  Value take_value(Taker& in) {
    const std::string_view name = in.text(), bytes = in.text();
    if (name.empty()) return {};
    const ValueType* type = session->catalogue().find(name);
    if (type == nullptr) throw Broken{"a value that this program does not know"};
    return good(Value::from_bytes(*type, bytes));
  }

  const std::vector<Event>& events_up_to(std::size_t i) {
    for (; events_of <= i; ++events_of) {
      are_events_known = true;
      try {
        take_events(good(session->read(session->checkpoints()[events_of].events)));
      } catch (const Broken&) {
        are_events_known = false;  // until one that has all of them
      }
    }
    if (!are_events_known) throw Broken{"missing events"};
    return events;
  }
  void take_events(const std::string& bytes) {
    Taker in(bytes);
    const std::uint64_t from = in.count();
    if (from > events.size()) throw Broken{"missing events"};
    events.resize(from);
    for (std::uint64_t left = in.count_of_things(); left > 0; --left) {
      Event event;
      event.tick = in.value<std::uint64_t>();
      event.hand = in.value<std::uint8_t>();
      event.place_world = in.place();
      event.what = take_value(in);
      if (event.what.is_empty()) throw Broken{"an event without a name"};
      events.push_back(std::move(event));
    }
  }
  const std::map<std::uint64_t, KeptEntry>& entries_up_to(std::size_t i) {
    for (; entries_of <= i; ++entries_of) {
      try {
        const std::string bytes = good(session->read(session->checkpoints()[entries_of].history));
        Taker in(bytes);
        while (!in.is_at_end()) {
          const std::uint64_t number = in.count();
          const volume::VoxelBox box = in.box(start.scene().base->size);
          entries.insert_or_assign(number, KeptEntry{box, std::string(in.text())});
        }
      } catch (const Broken&) {
        continue;  // a reader that needs one of them reports it
      }
    }
    return entries;
  }
  /// Back over as many checkpoints as it takes.
  std::vector<HandTrail> trails_at(std::size_t i) {
    struct Part {
      std::uint64_t first = 0, from = 0;
      std::vector<glm::dvec3> places;
    };
    std::vector<Part> all(start.hand_count());
    for (std::size_t k = i;; --k) {
      const std::string bytes = good(session->read(session->checkpoints()[k].trails));
      Taker in(bytes);
      bool is_whole = true;
      for (Part& part : all) {
        const std::uint64_t first = in.count(), from = in.count(), count = in.count_of_things();
        std::vector<glm::dvec3> places;
        for (std::uint64_t n = 0; n < count; ++n) places.push_back(in.place());
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
    for (const Part& part : all) {
      if (part.first - part.from > part.places.size()) throw Broken{"an invalid trail"};
      trails.push_back(HandTrail::of(part.first, std::span(part.places).subspan(part.first - part.from)));
    }
    return trails;
  }

  // ---- parts of an image ----

  struct Hands {
    std::vector<std::shared_ptr<const haptics::TouchScene>> scenes;
    std::vector<std::uint64_t> layouts;
  };
  /// `scene` null: they are read, and of no use.
  OffsetJob::Offsets take_offsets(Taker& in, const std::shared_ptr<const haptics::TouchScene>& scene) {
    OffsetJob::Offsets offsets(in.count(haptics::ShapeSet::k_most));
    if (scene && !offsets.empty() && offsets.size() != haptics::base_shapes(*scene).size())
      throw Broken{"fields of other shapes than there are"};
    for (std::size_t s = 0; s < offsets.size(); ++s) {
      const std::uint64_t chain = in.count(), link = in.count();
      if (scene) offsets[s] = field_at(chain, link, scene, s);
    }
    return offsets;
  }
  /// The scene that a hand had with a tool of then; null when it is gone.
  std::shared_ptr<const haptics::TouchScene> scene_of(std::size_t hand, std::uint64_t layout,
                                                      const Hands& hands) const {
    if (hands.layouts[hand] == layout) return hands.scenes[hand];
    const auto& first = start.servo_scene()->hands;
    for (std::size_t h = 0; layout == 0 && h < hands.scenes.size(); ++h)
      if (hands.layouts[h] == 0 && first[h].scene == first[hand].scene) return hands.scenes[h];
    return nullptr;
  }
  std::pair<std::shared_ptr<const haptics::TouchScene>, TouchFields::Kept> take_fields(Taker& in,
                                                                                       const Hands& hands) {
    const std::uint64_t hand = in.count(hands.scenes.size() - 1), layout = in.count();
    const auto scene = scene_of(hand, layout, hands);
    const volume::VoxelBox owed = in.box(start.scene().base->size);
    return {scene, {take_offsets(in, scene), owed}};
  }
  World take_world(Taker& in) {
    World world;
    world.version = version_at(in.count());
    world.modules = take_modules(in, start.now().world.modules);
    for (std::uint64_t left = in.count(haptics::TouchScene::k_max_movers); left > 0; --left) {
      Body body;
      body.id.value = static_cast<std::uint32_t>(in.count(~std::uint32_t{0}));
      body.mover = static_cast<int>(in.count(haptics::TouchScene::k_max_movers - 1));
      const std::uint64_t chain = in.count();
      std::shared_ptr<const Piece>& piece = pieces[chain];
      bool is_on = false;
      if (!piece) piece = piece_from_bytes(way_to(chain, 0, ~std::uint64_t{0}, is_on).back());
      if (!piece) throw Broken{"an invalid piece"};
      body.piece = piece;
      body.place = in.placement();
      const std::int64_t holder = in.signed_number();
      if (holder < -1 || holder >= static_cast<std::int64_t>(start.hand_count()))
        throw Broken{"a body in no hand"};
      body.holder = static_cast<int>(holder);
      if (holder >= 0) body.grip = in.placement();
      const auto is_taken = [&](const auto& item) { return item.mover == body.mover; };
      bool is_good = std::none_of(world.bodies.begin(), world.bodies.end(), is_taken) &&
                     (world.bodies.empty() || world.bodies.back().id.value < body.id.value);
      for (std::size_t h = 0; h < start.hand_count(); ++h)
        is_good = is_good && std::none_of(start.scene(h).items.begin(), start.scene(h).items.end(), is_taken);
      if (!is_good) throw Broken{"a body in another's place"};
      world.bodies.push_back(std::move(body));
    }
    return world;
  }
  HistoryPlace take_place(Taker& in, const Hands& hands) {
    HistoryPlace place;
    place.world = take_world(in);
    for (std::uint64_t left = in.count(haptics::ServoScene::k_most_hands); left > 0; --left)
      if (auto fields = take_fields(in, hands); fields.first) place.fields.push_back(std::move(fields));
    return place;
  }
  OperationState take_state(Taker& in, const std::vector<Event>& all_events) {
    const OperationState& like = start.now();
    OperationState state;
    state.next_tick = in.value<std::uint64_t>();
    state.world = take_world(in);
    state.settings.modules = take_modules(in, like.settings.modules);
    for (std::size_t h = 0; h < start.hand_count(); ++h) {
      const std::string_view name = in.text(), parameters = in.text(), memory = in.text();
      Instrument& hand = state.settings.hands.emplace_back();
      if (name.empty()) continue;
      hand.type = session->catalogue().find_instrument(name);
      if (hand.type == nullptr) throw Broken{"an instrument that this program does not have"};
      hand.parameters = good(Value::from_bytes(*hand.type->parameters, parameters));
      hand.state = good(Value::from_bytes(*hand.type->state, memory));
    }
    for (std::uint64_t left = in.count_of_things(); left > 0; --left) {
      std::string key(in.text());
      Command command;
      command.hand = in.value<std::uint8_t>();
      command.what = take_value(in);
      if (command.what.is_empty() || command.hand >= start.hand_count()) throw Broken{"an invalid command"};
      state.settings.told.emplace(std::move(key), std::move(command));
    }
    const std::uint64_t count = in.count(all_events.size());
    for (std::uint64_t i = 0; i < count; ++i) state.chronicle.add(all_events[i]);
    state.chronicle.undos = in.count();
    state.chronicle.redos = in.count();
    for (std::size_t w = 0; w < like.watches.size(); ++w)
      if (decode_fields(ForbiddenWatch::schema(), &state.watches.emplace_back(), in.text()))
        throw Broken{"a forbidden structure's values"};
    return state;
  }
  /// Scene of a hand: as it began, or with a tool that it was given.
  void take_hand(Taker& in, std::size_t h, EngineImage::Hand& hand) {
    ToolGeometry geometry{in.number(), {}};
    for (std::uint64_t left = in.count(haptics::TouchScene::k_most_balls); left > 0; --left)
      geometry.balls.push_back(in.place());
    hand.tool = start.tool(h);
    hand.tool.number = in.count();
    if (hand.tool.number != 0) {
      std::shared_ptr<const MadeGeometry>& made = geometries[{h, Value(geometry).bytes()}];
      if (!made) {
        if (check_tool_radius(*hand.tool.scene->base, geometry.radius)) throw Broken{"an invalid tool"};
        made = make_geometry(hand.tool, geometry, *start.now().world.version, k_no_voxels);
      }
      if (made->failed) throw Broken{"a tool that cannot be made"};
      hand.tool.scene = made->scene;
      hand.tool.method = made->method;
    }
    if (in.flags(1) != 0) {
      auto way = std::make_shared<haptics::WayOut>();
      way->serial = in.value<std::uint64_t>();
      way->count = static_cast<std::uint32_t>(in.count(haptics::WayOut::k_most_places));
      for (std::uint32_t i = 0; i < way->count; ++i) way->places_volume[i] = in.place();
      hand.way = std::move(way);
    }
    const auto flags = in.flags(15);
    hand.work.is_pressed = flags & 1;
    hand.work.is_fresh = flags & 2;
    hand.work.noted_faults = in.value<std::uint32_t>();
    if (flags & 4) {
      const glm::dvec3 centre = in.place();
      hand.work.body = ToolBall{centre, in.number()};
    }
    if (flags & 8) hand.work.place = in.placement();
  }

  void take_history(Taker& in, std::size_t i, const Hands& hands, EngineImage& image) {
    const auto& kept = entries_up_to(i);
    std::map<std::uint64_t, std::shared_ptr<const HistoryEntry>> made;  // branches share them
    const std::uint64_t others = in.count(Engine::k_most_branches - 1);
    image.branch = take_branch(in, hands, kept, made);
    for (std::uint64_t left = others; left > 0; --left)
      image.left_branches.push_back(take_branch(in, hands, kept, made));
    image.last_entry = in.count();
    image.growths = in.count();
    image.edits = in.count();
    image.last_job = static_cast<std::uint32_t>(in.count());
    image.last_body = static_cast<std::uint32_t>(in.count(~std::uint32_t{0}));
  }

  Branch take_branch(Taker& in, const Hands& hands, const std::map<std::uint64_t, KeptEntry>& kept,
                     std::map<std::uint64_t, std::shared_ptr<const HistoryEntry>>& made) {
    Branch branch;
    branch.name = in.text();
    std::uint64_t number = 0;
    for (std::uint64_t left = in.count(Engine::k_most_strokes + 1); left > 0; --left) {
      number += static_cast<std::uint64_t>(in.signed_number());
      std::shared_ptr<const HistoryEntry>& entry = made[number];
      if (!entry) entry = take_entry(number, hands, kept);
      branch.history.push_back(entry);
    }
    branch.position = in.count();
    branch.forgotten = in.count();
    if (branch.position >= branch.history.size()) throw Broken{"an invalid history entry"};
    return branch;
  }

  std::shared_ptr<const HistoryEntry> take_entry(std::uint64_t number, const Hands& hands,
                                                 const std::map<std::uint64_t, KeptEntry>& kept) {
    const auto found = kept.find(number);
    if (found == kept.end()) throw Broken{"a missing history entry"};
    HistoryEntry entry{number, found->second.box, {}, {}};
    entry.load = [shared = shared_from_this(), hands, bytes = found->second.place,
                  made = std::make_shared<std::optional<HistoryPlace>>()]() -> Result<HistoryPlace> {
      try {
        if (*made) return **made;
        if (shared->life.expired())
          return Error{"what was before is in a session that is read no more", "", "",
                       "its reader, as long as the operation goes on from it", ""};
        Taker place(bytes);
        return *(*made = shared->take_place(place, hands));
      } catch (const Broken& broken) {
        return error_of(broken);
      } catch (const std::bad_alloc&) {
        return error_of({"more than there is memory for"});
      }
    };
    return std::make_shared<const HistoryEntry>(std::move(entry));
  }

  void take_jobs(Taker& in, const std::vector<Event>& all_events, EngineImage& image) {
    for (std::uint64_t left = in.count_of_things(); left > 0; --left) {
      PendingJob job;
      job.id.value = static_cast<std::uint32_t>(in.count());
      job.hand = in.value<std::uint8_t>();
      job.parameters = std::make_shared<const Value>(take_value(in));
      job.growths = in.count();
      job.edits = in.count();
      job.cut = in.box(start.scene().base->size);
      job.input = std::make_shared<const OperationState>(take_state(in, all_events));
      if (job.hand >= start.hand_count() || job.parameters->is_empty()) throw Broken{"an invalid job"};
      if (!job.parameters->as<ToolGeometry>() && !job.parameters->as<FreePieces>() &&
          !start.find_job(job.parameters->type(), job.type, job.module))
        throw Broken{"a job that this program does not have"};
      const haptics::TouchScene& anatomy = *start.tool(job.hand).scene;
      const auto* pieces = job.parameters->as<FreePieces>();
      if ((pieces && check_shape_of_pieces(anatomy, pieces->item, "")) ||
          (job.type && job.type->check && job.type->check(job.parameters->data(), anatomy)))
        throw Broken{"a job that does not fit"};
      image.jobs.push_back(std::move(job));
    }
  }

  Checkpoint take(std::size_t i) {
    const CheckpointIndex& index = session->checkpoints()[i];
    const std::string bytes = good(session->read(index.rest));
    const std::vector<Event>& all_events = events_up_to(i);
    std::vector<HandTrail> trails = trails_at(i);
    Checkpoint all;
    all.block = index.block;
    all.next_tick = index.next_tick;
    Taker in(bytes);
    const std::size_t count = start.hand_count();
    for (std::size_t h = 0; h < count; ++h) all.cores.emplace_back(in.text());
    for (std::uint64_t left = in.count(CheckpointMaker::k_most_records); left > 0; --left) {
      all.records.push_back(in.record());
      if (all.records.back().hand >= count) throw Broken{"a tick of no hand"};
    }
    EngineImage& image = all.image;
    image.hands.resize(count);
    Hands hands;
    for (std::size_t h = 0; h < count; ++h) {
      take_hand(in, h, image.hands[h]);
      image.hands[h].trail = std::move(trails[h]);
      hands.scenes.push_back(image.hands[h].tool.scene);
      hands.layouts.push_back(image.hands[h].tool.number);
    }
    take_history(in, i, hands, image);
    image.is_stroke_changed = in.flags(1) != 0;
    image.stroke_box = in.box(start.scene().base->size);
    image.ever_cut = in.box(start.scene().base->size);
    take_jobs(in, all_events, image);
    image.serial = in.value<std::uint64_t>();
    image.now = take_state(in, all_events);
    for (std::uint64_t left = in.count(count); left > 0; --left) {
      auto [scene, kept] = take_fields(in, hands);
      const bool is_twice = std::any_of(image.fields.begin(), image.fields.end(),
                                        [&, s = scene](const TouchFields& f) { return f.scene() == s; });
      if (!scene || is_twice || !(scene->tool_radius > 0)) throw Broken{"a tool's field of no hand"};
      std::vector<std::pair<std::uint64_t, volume::VoxelBox>> cuts(in.count_of_things());
      for (auto& [serial, box] : cuts) {
        serial = in.value<std::uint64_t>();
        box = in.box(scene->base->size);
      }
      image.fields.push_back(TouchFields::of(scene, std::move(kept), cuts, image.now.world.version));
    }
    for (std::uint64_t left = in.count_of_things(); left > 0; --left) {
      Checkpoint::Fields& made = all.fields.emplace_back();
      made.serial = in.value<std::uint64_t>();
      made.hand = in.value<std::uint8_t>();
      if (made.hand >= count) throw Broken{"a tool's field of no hand"};
      made.offsets = take_offsets(in, hands.scenes[made.hand]);
    }
    if (!in.is_at_end()) throw Broken{"more than there should be"};
    return all;
  }

  static Error error_of(const Broken& broken) {
    return {"a checkpoint of the session is broken", "", broken.what, "what trephine wrote",
            "it can be opened from its start"};
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
    return shared_->take(i);
  } catch (const Broken& broken) {
    return Shared::error_of(broken);
  } catch (const std::bad_alloc&) {
    return Shared::error_of({"more than there is memory for"});
  }
}

CheckpointTail CheckpointStore::tail() {
  CheckpointTail tail;
  for (const auto& [place, link] : shared_->links) {
    if (place.first == 0) tail.next_link = place.second + 1;
    tail.next_chain = std::max(tail.next_chain, place.first + 1);
  }
  if (size() == 0) return tail;
  const Result<Checkpoint> newest = read(size() - 1);
  if (!newest) return tail;
  const EngineImage& image = newest.value().image;
  tail.version = image.now.world.version;
  tail.last_entry = image.last_entry;
  tail.events = image.now.chronicle.size();
  for (const EngineImage::Hand& hand : image.hands) tail.places.push_back(hand.trail.count());
  return tail;
}

}  // namespace trephine::sim
