// Engine: detached bodies and implants, which hands grasp and release.
#include <algorithm>
#include <array>
#include <cmath>

#include "haptics/methods/methods.h"
#include "sim/engine/core_commands.h"

namespace trephine::sim {

namespace {

struct PiecesResult final : JobResult {
  Detachment pieces;
  std::uint64_t fingerprint = 0;
  std::uint64_t hash() const override { return fingerprint; }
  const Detachment* detachment() const noexcept override { return &pieces; }
};

Error no_body(const char* command, Id id) {
  return Error{.what = "unknown body",
               .where = command,
               .found = "body " + std::to_string(id.value),
               .expected = "a detached body or an implant",
               .remedy = "choose a body that exists"};
}

/// Checks that a body can be grasped or placed.
Status check_free(const Body& body, const char* command) {
  if (body.is_fixed)
    return Error{.what = "the body is fixed",
                 .where = command,
                 .found = "body " + std::to_string(body.id.value),
                 .expected = "a body that is not fixed",
                 .remedy = "discard it, or undo its placement"};
  if (body.holder >= 0)
    return Error{.what = "the body is held by a hand",
                 .where = command,
                 .found = "hand " + std::to_string(body.holder + 1),
                 .expected = "a released body",
                 .remedy = "release the body first"};
  return std::nullopt;
}

/// Returns the number of the first layout (ServoHand::layout) in which the scene of a hand contains the body
/// at its current pose.
std::uint64_t since_of(const haptics::ServoHand& hand, const Body& body) {
  for (const haptics::TouchItem& item : hand.scene->items)
    if (item.tree == body.piece->tree && item.mover == body.mover &&
        (body.mover < 0 ? item.placement : hand.placements[static_cast<std::size_t>(body.mover)]) ==
            body.placement)
      return item.first_layout;
  return hand.layout + 1;
}

template <class Bodies>
auto find_body(Bodies& bodies, Id id) {
  return std::find_if(bodies.begin(), bodies.end(), [&](const Body& body) { return body.id == id; });
}
template <class Bodies>
auto find_held_body(Bodies& bodies, std::uint8_t hand) {
  return std::find_if(bodies.begin(), bodies.end(), [&](const Body& body) { return body.holder == hand; });
}

}  // namespace

std::shared_ptr<const JobResult> make_pieces(const haptics::TouchItem& shape, const FreePieces& request,
                                             std::vector<volume::Field> solids, const OperationState& input) {
  auto result = std::make_shared<PiecesResult>();
  result->pieces = detach_free_pieces(shape, request, std::move(solids), input.undoable.version);
  result->fingerprint = hash_of(result->pieces);
  return result;
}

/// Returns the movers that neither a model nor a body uses.
std::vector<int> Engine::free_movers() const {
  std::vector<int> free;
  for (int m = 0; m < haptics::TouchScene::k_max_movers; ++m) {
    const auto is_used = [m](const haptics::TouchItem& item) { return item.mover == m; };
    bool is_free = std::none_of(state_.undoable.bodies.begin(), state_.undoable.bodies.end(),
                                [m](const Body& body) { return body.mover == m; });
    for (const HandTool& tool : tools_)
      is_free = is_free && std::none_of(tool.scene->items.begin(), tool.scene->items.end(), is_used);
    if (is_free) free.push_back(m);
  }
  return free;
}

/// Checks that every hand can touch bodies in addition to the anatomy.
Status Engine::check_room_for_bodies() const {
  for (const HandTool& tool : tools_) {
    // Only the general methods touch anatomy and models together, and they touch the smooth solid of the
    // anatomy.
    if (tool.method->info().solid != haptics::MethodInfo::Solid::smooth)
      return Error{.what = "the contact method of a hand does not support detached bodies",
                   .found = tool.method->name(),
                   .expected = "a method that touches the smooth solid",
                   .remedy = "use method subvoxel or scene"};
    if (haptics::item_count(*tool.scene) + haptics::TouchScene::k_max_movers > haptics::ShapeSet::k_max)
      return Error{.what = "a hand touches too many objects to touch detached bodies as well",
                   .found = std::to_string(haptics::item_count(*tool.scene)) + " objects",
                   .expected = "at most " +
                               std::to_string(haptics::ShapeSet::k_max - haptics::TouchScene::k_max_movers),
                   .remedy = "start the session with fewer shapes or models that are touched"};
  }
  return std::nullopt;
}

/// Checks that there is room for another body. `command`: name of the command, for the error.
Status Engine::check_room_for_pieces(std::string_view command) const {
  if (Status error = check_room_for_bodies()) return error;
  if (!free_movers().empty()) return std::nullopt;
  return Error{.what = "too many objects that move",
               .where = std::string(command),
               .found = std::to_string(haptics::TouchScene::k_max_movers) + " bodies and models that move",
               .expected = "fewer than " + std::to_string(haptics::TouchScene::k_max_movers),
               .remedy = "discard a body"};
}

struct BodyCommands {
  static Status check_free_pieces(const Engine& engine, const FreePieces& request, std::uint8_t hand) {
    if (Status error = check_shape_of_pieces(*engine.tools_[hand].scene, request.item, "free-pieces item"))
      return error;
    return engine.check_room_for_pieces("free-pieces");
  }
  static void begin_free_pieces(Engine& engine, const FreePieces& request, std::uint8_t hand,
                                Outcome& outcome) {
    engine.begin_job({request, hand}, {}, outcome);
  }

  static Status check_hold(const Engine& engine, const HoldBody& request, std::uint8_t hand) {
    const std::vector<Body>& bodies = engine.state_.undoable.bodies;
    const auto body = find_body(bodies, request.body);
    if (body == bodies.end()) return no_body("hold-body", request.body);
    if (Status error = check_free(*body, "hold-body")) return error;
    if (find_held_body(bodies, hand) != bodies.end())
      return Error{.what = "the hand holds a body",
                   .where = "hold-body",
                   .expected = "an empty hand",
                   .remedy = "release the body first"};
    if (!engine.work_[hand].placement)
      return Error{.what = "the hand's position is unknown",
                   .where = "hold-body",
                   .expected = "a hand whose device has sent a position",
                   .remedy = "move the device first"};
    return std::nullopt;
  }
  static void hold(Engine& engine, const HoldBody& request, std::uint8_t hand, Outcome& outcome) {
    Body& body = *find_body(engine.state_.undoable.bodies, request.body);
    body.holder = hand;
    body.grip = engine.work_[hand].placement->inverse() * body.placement;
    publish(engine, Engine::Bodies::same, outcome);  // no edit: only the release is an undoable change
  }

  static Status check_release(const Engine& engine, const ReleaseBody&, std::uint8_t hand) {
    const std::vector<Body>& bodies = engine.state_.undoable.bodies;
    if (find_held_body(bodies, hand) != bodies.end()) return std::nullopt;
    return Error{.what = "the hand holds no body",
                 .where = "release-body",
                 .expected = "a held body",
                 .remedy = "grasp a body first, with hold-body"};
  }
  static void release(Engine& engine, const ReleaseBody&, std::uint8_t hand, Outcome& outcome) {
    engine.release_body(*find_held_body(engine.state_.undoable.bodies, hand));
    publish_edit(engine, Engine::Bodies::same, outcome);
  }

  static Status check_place(const Engine& engine, const PlaceBody& request, std::uint8_t) {
    const std::vector<Body>& bodies = engine.state_.undoable.bodies;
    const auto body = find_body(bodies, request.body);
    if (body == bodies.end()) return no_body("place-body", request.body);
    if (Status error = check_free(*body, "place-body")) return error;
    return check_rotation(request.rotation, "place-body rotation");
  }
  static void place(Engine& engine, const PlaceBody& request, std::uint8_t, Outcome& outcome) {
    const std::vector<double>& q = request.rotation;
    find_body(engine.state_.undoable.bodies, request.body)->placement = {request.position,
                                                                         {q[0], q[1], q[2], q[3]}};
    // The body counts as a new item at its new pose, so that it pushes no hand.
    publish_edit(engine, Engine::Bodies::changed, outcome);
  }

  static Status check_discard(const Engine& engine, const DiscardBody& request, std::uint8_t) {
    const std::vector<Body>& bodies = engine.state_.undoable.bodies;
    return find_body(bodies, request.body) == bodies.end() ? no_body("discard-body", request.body) : Status();
  }
  static void discard(Engine& engine, const DiscardBody& request, std::uint8_t, Outcome& outcome) {
    std::vector<Body>& bodies = engine.state_.undoable.bodies;
    bodies.erase(find_body(bodies, request.body));
    publish_edit(engine, Engine::Bodies::changed, outcome);
  }

 private:
  static void publish(Engine& engine, Engine::Bodies update, Outcome& outcome) {
    engine.use_bodies(update);
    engine.publish(Engine::Change::removal);
    outcome.is_changed = true;
  }
  static void publish_edit(Engine& engine, Engine::Bodies update, Outcome& outcome) {
    publish(engine, update, outcome);
    engine.is_stroke_changed_ = outcome.is_edit = true;
  }
};

std::span<const CoreCommand> body_commands() noexcept {
  using Group = BodyCommands;
  static const std::array all{
      core_command<FreePieces, &Group::begin_free_pieces, &Group::check_free_pieces>(
          {.step_rule = StepRule::every_step}),
      core_command<HoldBody, &Group::hold, &Group::check_hold>(),
      core_command<ReleaseBody, &Group::release, &Group::check_release>({.step_rule = StepRule::every_step}),
      core_command<PlaceBody, &Group::place, &Group::check_place>({.step_rule = StepRule::named}),
      core_command<DiscardBody, &Group::discard, &Group::check_discard>({.step_rule = StepRule::named})};
  return all;
}

/// Removes bodies for a module. Returns false if no such body exists.
bool Engine::remove_bodies(std::span<const Id> ids) {
  const std::size_t removed = std::erase_if(state_.undoable.bodies, [&](const Body& body) {
    return std::find(ids.begin(), ids.end(), body.id) != ids.end();
  });
  if (removed > 0) use_bodies(Bodies::changed);
  return removed > 0;
}

haptics::Placement Engine::placement_of(const Body& body) const {
  haptics::Placement placement = body.placement;
  if (is_in_motion(body))
    return body.motion.at(static_cast<double>(state_.next_tick - body.motion.begin_tick) * state_.dt,
                          placement);
  if (body.holder < 0) return placement;
  const HandWork& hand = work_[static_cast<std::size_t>(body.holder)];
  if (hand.placement) placement = *hand.placement * body.grip;
  placement.rotation = glm::normalize(placement.rotation);
  return placement;
}

bool Engine::is_in_motion(const Body& body) const noexcept {
  return body.motion.seconds > 0 && state_.next_tick < end_of(body.motion);
}

/// Returns the first tick at which a motion has ended.
std::uint64_t Engine::end_of(const BodyMotion& motion) const noexcept {
  return motion.begin_tick + static_cast<std::uint64_t>(std::ceil(motion.seconds / state_.dt));
}

haptics::Placement Engine::placement_of(const haptics::TouchItem& item) const {
  const haptics::ServoHand& hand = servo_scene_->hands[0];
  const bool is_moved = item.mover >= 0 && static_cast<std::size_t>(item.mover) < hand.placement_count;
  return is_moved ? hand.placements[static_cast<std::size_t>(item.mover)] : item.placement;
}

std::vector<const haptics::TouchItem*> Engine::models() const {
  std::vector<const haptics::TouchItem*> result;
  const std::vector<Body>& bodies = state_.undoable.bodies;
  for (const haptics::TouchItem& item : scene().items)
    if (item.tree && std::none_of(bodies.begin(), bodies.end(),
                                  [&](const Body& body) { return body.piece->tree == item.tree; }))
      result.push_back(&item);
  return result;
}

std::shared_ptr<const haptics::MeshTree> Engine::surface_of(const haptics::TouchItem& model) const {
  std::shared_ptr<const haptics::MeshTree> surface;
  if (model.depth) surface = model.depth->surface_at(seconds());
  return surface ? surface : model.tree;
}

bool Engine::has_moving_surfaces() const {
  const std::vector<haptics::TouchItem>& items = scene().items;
  const std::vector<Body>& bodies = state_.undoable.bodies;
  if (std::any_of(bodies.begin(), bodies.end(), [&](const Body& body) { return is_in_motion(body); }))
    return true;
  for (const Module* module : catalogue_.modules())
    if (module->is_moving(state_)) return true;
  return std::any_of(items.begin(), items.end(), [&](const haptics::TouchItem& item) {
    return item.depth && item.depth->is_moving(seconds());
  });
}

std::vector<DisplayedDepths> Engine::displayed_depths(std::size_t hand) const {
  std::vector<DisplayedDepths> result;
  const double time = seconds();
  for (int i = 0; i < haptics::item_count(scene()); ++i)
    if (const auto at = depths_[hand].index_of(i))
      if (const auto& set = depths_[hand].newest()[*at]) {
        const haptics::Placement item_pose = placement_of(haptics::item_of(scene(), i));
        result.push_back({i, set, item_pose, item_pose * set->displacement_at(time)});
      }
  return result;
}

void Engine::release_body(Body& body) {
  body.placement = placement_of(body);
  body.holder = -1;
  body.grip = {};
}

/// Releases all held bodies, since devices start again at unknown positions.
void Engine::release_all_bodies(Outcome& outcome) {
  bool was_held = false;
  for (Body& body : state_.undoable.bodies)
    if (body.holder >= 0) release_body(body), was_held = true;
  if (!was_held) return;
  use_bodies(Bodies::same);
  publish(Change::removal);
  is_stroke_changed_ = outcome.is_edit = outcome.is_changed = true;
  end_stroke();
}

/// Returns the reason why a detachment cannot be adopted; empty if it can be adopted.
std::string Engine::reason_not_to_adopt(const Detachment& detachment) const {
  if (detachment.piece_count == 0 && detachment.debris == 0) return "no part is disconnected";
  if (const std::size_t room = free_movers().size(); detachment.piece_count > room)
    return std::to_string(detachment.piece_count) + " pieces are disconnected, and there is room for " +
           std::to_string(room) + ": discard bodies first";
  const Status no_room = check_room_for_bodies();
  return no_room ? no_room->message() : std::string();
}

void Engine::adopt(const Detachment& detachment, std::uint8_t hand, Outcome& outcome) {
  const std::vector<int> movers = free_movers();
  editor_.reset(detachment.rest);
  state_.undoable.version = published_version_ = editor_.publish();
  ++state_.edits;
  for (std::size_t i = 0; i < detachment.pieces.size(); ++i) {
    const std::shared_ptr<const Piece>& piece = detachment.pieces[i];
    const Id id{++last_body_};
    state_.undoable.bodies.push_back({id, movers[i], piece, {}, -1});
    pending_events_.push_back({state_.next_tick, hand, piece->middle_world, PieceFreed{id, piece->mm3}});
  }
  if (detachment.debris > 0)
    pending_events_.push_back(
        {state_.next_tick, hand, glm::dvec3(0), DebrisFreed{detachment.debris, detachment.debris_mm3}});
  use_bodies(Bodies::changed);
  publish(Change::removal);
  volume::RemovalReport report;
  report.box = detachment.box;
  record_cut(report);
  outcome.is_changed = outcome.is_edit = true;
  outcome.box = detachment.box;
}

/// Returns the reason why implants cannot be added; empty if they can be added.
std::string Engine::reason_not_to_add(std::span<const NewBody> bodies) const {
  const auto moving = static_cast<std::size_t>(
      std::count_if(bodies.begin(), bodies.end(), [](const NewBody& body) { return !body.is_fixed; }));
  if (const std::size_t room = free_movers().size(); moving > room)
    return std::to_string(moving) + " movable implants were added, and there is room for " +
           std::to_string(room) + ": discard bodies first";
  for (const HandTool& tool : tools_)
    if (haptics::item_count(*tool.scene) + static_cast<int>(state_.undoable.bodies.size() + bodies.size()) +
            haptics::TouchScene::k_max_movers >
        haptics::ShapeSet::k_max)
      return "a hand can touch at most " + std::to_string(haptics::ShapeSet::k_max) +
             " objects: discard bodies first";
  const Status no_room = check_room_for_bodies();
  return no_room ? no_room->message() : std::string();
}

void Engine::add(std::span<const NewBody> bodies, std::uint8_t hand, Outcome& outcome) {
  const std::vector<int> movers = free_movers();
  std::size_t used = 0;
  for (const NewBody& one : bodies) {
    Body body;
    body.id = Id{++last_body_};
    body.mover = one.is_fixed ? -1 : movers[used++];
    body.piece = one.piece, body.placement = one.placement, body.matter = one.matter;
    body.is_implant = true, body.is_fixed = one.is_fixed;
    body.motion = one.motion, body.motion.begin_tick = state_.next_tick;
    pending_events_.push_back({state_.next_tick, hand,
                               one.placement.world_from_local(one.piece->middle_world),
                               BodyAdded{body.id, one.piece->mm3}});
    state_.undoable.bodies.push_back(std::move(body));
  }
  use_bodies(Bodies::changed);
  publish(Change::removal);
  is_stroke_changed_ = outcome.is_changed = outcome.is_edit = true;
}

/// Lets hands touch the bodies whose motion ended since `previous_tick`.
void Engine::end_motions(std::uint64_t previous_tick, Outcome& outcome) {
  const std::vector<Body>& bodies = state_.undoable.bodies;
  const auto is_ending = [&](const Body& body) {
    const std::uint64_t end = end_of(body.motion);
    return body.motion.seconds > 0 && previous_tick < end && end <= state_.next_tick;
  };
  if (std::none_of(bodies.begin(), bodies.end(), is_ending)) return;
  use_bodies(Bodies::changed);
  publish(Change::removal);
  outcome.is_changed = true;
}

/// Updates the scenes of the hands with the current bodies. `changed`: bodies were added or removed, or
/// jumped to other poses. A jump does not push a hand.
void Engine::use_bodies(Bodies update) {
  for (std::size_t h = 0; h < hands_.size(); ++h) use_bodies(h, update);
}

void Engine::use_bodies(std::size_t h, Bodies update) {
  const std::vector<Body>& bodies = state_.undoable.bodies;
  haptics::ServoHand& hand = hands_[h];
  const HandTool& tool = tools_[h];
  const int first = haptics::item_count(*tool.scene);
  if (update == Bodies::changed && bodies.empty()) {
    hand.set_scene(tool.scene, tool.method);
  } else if (update == Bodies::changed) {
    auto scene = std::make_shared<haptics::TouchScene>(*tool.scene);
    for (const Body& body : bodies) {
      haptics::TouchItem item =
          haptics::mesh_item("body " + std::to_string(body.id.value), body.piece->tree, body.piece->material);
      item.mover = body.mover;
      if (body.mover < 0) item.placement = body.placement;
      item.matter = body.matter;
      item.first_layout = since_of(hand, body);
      scene->items.push_back(std::move(item));
    }
    std::shared_ptr<haptics::ProxyMethod> method =
        haptics::make_method(haptics::general_method(*tool.scene->tool).name).value();
    const Status error = method->prepare(*scene);
    TREPHINE_ASSERT(!error);  // check_room_for_bodies() has checked this
    hand.set_scene(std::move(scene), std::move(method));
  }
  hand.release_held();
  for (std::size_t b = 0; b < bodies.size(); ++b) {
    const Body& body = bodies[b];
    if (body.mover >= 0) hand.set_placement(body.mover, body.placement);
    // A hand does not touch the body that it holds, and no hand touches a body in motion.
    hand.set_touchable(first + static_cast<int>(b),
                       body.holder != static_cast<int>(h) && !is_in_motion(body));
    if (body.holder >= 0) hand.set_held(body.mover, static_cast<std::uint8_t>(body.holder), body.grip);
  }
}

}  // namespace trephine::sim
