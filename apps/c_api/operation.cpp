#include "apps/c_api/operation.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <optional>

#include "haptics/c_api/c_parts.h"
#include "modules/catalogue.h"
#include "sim/drivers/lockstep.h"
#include "sim/drivers/replay.h"
#include "volume/cuts/operated_volume.h"

using namespace trephine;
using haptics::c_api::bad;
using haptics::c_api::fail;
using haptics::c_api::guarded;

/// An operation that is driven by its caller (`run`), or by a file (`replay`).
struct trephine_operation {
  sim::SceneDescription scene;
  double air = -1000;
  std::unique_ptr<sim::SessionWriter> recorder;
  std::optional<sim::Lockstep> run;
  std::unique_ptr<sim::SessionReader> session;
  std::unique_ptr<sim::Replay> replay;
  bool has_ended = false;
  std::vector<haptics::Pose> poses;
  volume::VoxelBox changed = sim::k_no_voxels;

  ~trephine_operation() {
    if (recorder && !has_ended) (void)recorder->finish(run->engine());
  }
  const sim::Engine& engine() const noexcept { return run ? run->engine() : replay->engine(); }
  sim::Engine& engine() noexcept { return run ? run->engine() : replay->engine(); }
};

namespace {

/// Returns the volumes as scene data; the voxels remain owned by the caller.
Result<sim::SceneData> borrow_data(const trephine_voxels* volumes, std::size_t count) {
  sim::SceneData data;
  if (count > 0 && volumes == nullptr) return bad("an argument is missing", "NULL", "volumes");
  for (std::size_t v = 0; v < count; ++v) {
    const trephine_voxels& input = volumes[v];
    auto result = haptics::c_api::borrow_volume(input.intensities, input.size, input.origin, input.axes);
    if (!result) return result.error();
    result.value()->is_hounsfield = input.is_hounsfield != 0;
    if (input.labels)
      result.value()->labels = Buffer<std::uint8_t>::borrow(input.labels, result.value()->voxels.size());
    data.volumes.push_back(std::move(result).value());
  }
  return data;
}

Status begin(trephine_operation& result, const trephine_start& start) {
  if (start.scene == nullptr || start.volume_count < 1 || (start.model_count > 0 && start.models == nullptr))
    return bad("an argument is missing", "NULL", "a scene, at least one volume, and model_count models");
  Result<sim::SceneData> data = borrow_data(start.volumes, start.volume_count);
  if (!data) return data.error();
  for (std::size_t m = 0; m < start.model_count; ++m) {
    const trephine_model& model = start.models[m];
    auto tree =
        haptics::c_api::copy_mesh(model.vertices, model.vertex_count, model.triangles, model.triangle_count);
    if (!tree) return tree.error();
    data.value().models.push_back(std::move(tree).value());
  }
  Result<sim::SceneDescription> description = sim::scene_from_text(start.scene, data.value());
  if (!description) return description.error();
  sim::SceneDescription spec = std::move(description).value();
  const volume::Volume& anatomy = *data.value().volumes[0];
  const auto smallest = spec.smallest_burr > 0 ? std::optional(spec.smallest_burr) : std::nullopt;
  if (Status error = sim::apply_tool_needs(spec, anatomy, modules::catalogue(), smallest)) return error;
  spec.is_softening = sim::touches_smooth(spec);
  auto built = sim::build_scene(spec, data.value(), modules::catalogue());
  if (!built) return built.error();
  result.scene = sim::describe_built_scene(spec, built.value());
  result.air = volume::air_of(anatomy);
  if (start.record) {
    sim::SessionHeader header(result.scene);
    header.program = "trephine " TREPHINE_VERSION " (C interface)";
    sim::WriterOptions options;
    options.is_embedding = start.is_embedding != 0;
    auto recorder =
        sim::SessionWriter::create(start.record, header, data.value(), modules::catalogue(), options);
    if (!recorder) return recorder.error();
    result.recorder = std::move(recorder).value();
  }
  result.run.emplace(sim::Engine(built.value().hands, 1 / spec.rate_hz, modules::catalogue(),
                                 built.value().forbidden, built.value().plan),
                     spec.force, spec.rate_hz, result.recorder.get());
  result.poses.resize(result.run->engine().hand_count());
  return std::nullopt;
}

Status open(trephine_operation& result, const char* path, const trephine_voxels* volumes, std::size_t count) {
  if (path == nullptr) return bad("an argument is missing", "NULL", "a session's file");
  Result<sim::SceneData> data = borrow_data(volumes, count);
  if (!data) return data.error();
  auto session = sim::SessionReader::open(path, modules::catalogue());
  if (!session) return session.error();
  result.session = std::make_unique<sim::SessionReader>(std::move(session).value());
  auto replay = sim::Replay::open(*result.session, std::move(data).value());
  if (!replay) return replay.error();
  result.replay = std::move(replay).value();
  result.scene = result.session->header();
  result.air = volume::air_of(*result.engine().scene().base);
  return std::nullopt;
}

template <class Initialize>
trephine_operation* make(trephine_error* error, Initialize&& initialize) noexcept {
  std::unique_ptr<trephine_operation> result;
  const int code = guarded(error, [&]() -> Status {
    result = std::make_unique<trephine_operation>();
    return initialize(*result);
  });
  return code == TREPHINE_OK ? result.release() : nullptr;
}

Status check_run(const trephine_operation* operation) {
  if (operation == nullptr) return bad("there is no operation", "NULL", "one from trephine_operation_begin");
  if (!operation->run)
    return bad("a recorded operation cannot be changed", "opened", "one from trephine_operation_begin");
  if (operation->has_ended) return bad("the operation has ended", "ended", "an operation that has not ended");
  return std::nullopt;
}
Status check_replay(const trephine_operation* operation) {
  if (operation != nullptr && operation->replay) return std::nullopt;
  return bad("this operation was not recorded", operation ? "begun" : "NULL",
             "one from trephine_operation_open");
}

haptics::Pose pose_of(const trephine_pose& input) noexcept {
  haptics::Pose pose;
  pose.position_world = {input.position[0], input.position[1], input.position[2]};
  pose.orientation = {input.rotation[0], input.rotation[1], input.rotation[2], input.rotation[3]};
  const double length = glm::length(pose.orientation);
  if (length < 1e-6)
    pose.orientation = {1, 0, 0, 0};
  else
    pose.orientation /= length;  // NaN remains NaN
  pose.buttons = input.buttons;
  return pose;
}

template <std::size_t N>
void copy_text(char (&to)[N], std::string_view text) noexcept {
  const std::size_t length = std::min(text.size(), N - 1);
  std::memcpy(to, text.data(), length);
  to[length] = '\0';
}

}  // namespace

uint32_t trephine_operation_abi_version(void) { return TREPHINE_OPERATION_ABI_VERSION; }

trephine_operation* trephine_operation_begin(const trephine_start* start, trephine_error* error) {
  return make(error, [&](trephine_operation& result) -> Status {
    if (start == nullptr) return bad("an argument is missing", "NULL", "a trephine_start");
    return begin(result, *start);
  });
}

trephine_operation* trephine_operation_open(const char* session, const trephine_voxels* volumes,
                                            size_t volume_count, trephine_error* error) {
  return make(error,
              [&](trephine_operation& result) { return open(result, session, volumes, volume_count); });
}

void trephine_operation_destroy(trephine_operation* operation) { delete operation; }

int trephine_operation_step(trephine_operation* operation, const trephine_pose* poses,
                            trephine_touch* touches, trephine_error* error) {
  return guarded(error, [&]() -> Status {
    if (Status invalid = check_run(operation)) return invalid;
    if (poses == nullptr) return bad("there are no poses", "NULL", "one pose per hand");
    for (std::size_t h = 0; h < operation->poses.size(); ++h) operation->poses[h] = pose_of(poses[h]);
    const auto records = operation->run->step(operation->poses);
    operation->changed = sim::united(operation->changed, operation->run->last_outcome().box);
    if (touches)
      for (std::size_t h = 0; h < records.size(); ++h) touches[h] = haptics::c_api::touch_of(records[h]);
    return std::nullopt;
  });
}

int trephine_operation_command(trephine_operation* operation, int hand, const char* command,
                               const char* words, trephine_error* error) {
  Status refused;
  const int code = guarded(error, [&]() -> Status {
    if (Status invalid = check_run(operation)) return invalid;
    if (command == nullptr) return bad("there is no command", "NULL", "a name");
    if (hand < 0 || hand >= static_cast<int>(operation->poses.size()))
      return bad("unknown hand", std::to_string(hand), "an index of a hand of the scene");
    auto request = modules::catalogue().command(command, words ? words : "", hand);
    if (!request) return request.error();
    const sim::Outcome outcome = operation->run->apply_whole(request.value());
    operation->changed = sim::united(operation->changed, outcome.box);
    refused = outcome.refused;
    return std::nullopt;
  });
  return refused ? fail(error, TREPHINE_REFUSED, *refused) : code;
}

int trephine_operation_reset(trephine_operation* operation) {
  return guarded(nullptr, [&]() -> Status {
    if (Status invalid = check_run(operation)) return invalid;
    operation->run->reset();
    return std::nullopt;
  });
}

int trephine_operation_end(trephine_operation* operation, trephine_error* error) {
  Status failed;
  const int code = guarded(error, [&]() -> Status {
    if (Status invalid = check_run(operation)) return invalid;
    operation->has_ended = true;
    if (operation->recorder) failed = operation->recorder->finish(operation->run->engine());
    return std::nullopt;
  });
  return failed ? fail(error, TREPHINE_FAILED, *failed) : code;
}

int trephine_operation_go_to(trephine_operation* operation, uint64_t tick, trephine_error* error) {
  return guarded(error, [&]() -> Status {
    if (Status invalid = check_replay(operation)) return invalid;
    return operation->replay->seek(tick);
  });
}

int trephine_operation_verify(trephine_operation* operation, trephine_error* error) {
  Status failed, different;
  const int code = guarded(error, [&]() -> Status {
    if (Status invalid = check_replay(operation)) return invalid;
    sim::Replay& replay = *operation->replay;
    failed = replay.why_not_verifiable();
    if (!failed) failed = replay.seek(0);
    for (bool has_next = !failed; has_next;) {
      const Result<bool> stepped = replay.step();
      if (!stepped) failed = stepped.error();
      has_next = stepped && stepped.value();
    }
    if (!failed && operation->session->is_damaged())
      failed = Error{.what = "the session is damaged",
                     .where = "byte " + std::to_string(operation->session->complete_bytes()),
                     .expected = "a whole file",
                     .remedy = "the part before this tick was compared"};
    if (const std::optional<sim::Mismatch>& found = replay.mismatch())
      different = Error{.what = "the replay differs from the recording",
                        .where = "tick " + std::to_string(found->tick),
                        .found = found->what + " " + found->replayed,
                        .expected = found->recorded};
    return std::nullopt;
  });
  if (different) return fail(error, TREPHINE_DIFFERENT, *different);
  return failed ? fail(error, TREPHINE_FAILED, *failed) : code;
}

int trephine_operation_is_whole(const trephine_operation* operation) {
  return operation && operation->session && operation->session->end().has_value();
}

uint64_t trephine_operation_tick(const trephine_operation* operation) {
  return operation ? operation->engine().now().next_tick : 0;
}

uint64_t trephine_operation_tick_count(const trephine_operation* operation) {
  if (operation == nullptr) return 0;
  return operation->run ? operation->engine().now().next_tick : operation->session->tick_count();
}

size_t trephine_operation_hand_count(const trephine_operation* operation) {
  return operation ? operation->engine().hand_count() : 0;
}

size_t trephine_operation_scene(const trephine_operation* operation, char* text, size_t capacity) {
  std::string scene;
  if (guarded(nullptr, [&]() -> Status {
        if (operation) scene = sim::to_text(operation->scene);
        return std::nullopt;
      }) != TREPHINE_OK)
    return 0;
  if (text && capacity > 0) {
    const std::size_t length = std::min(scene.size(), capacity - 1);
    std::memcpy(text, scene.data(), length);
    text[length] = '\0';
  }
  return scene.size();
}

uint64_t trephine_operation_hash(trephine_operation* operation) {
  std::uint64_t hash = 0;
  guarded(nullptr, [&]() -> Status {
    if (operation) hash = operation->engine().snapshot()->hash();
    return std::nullopt;
  });
  return hash;
}

size_t trephine_operation_event_count(const trephine_operation* operation) {
  return operation ? operation->engine().now().chronicle.size() : 0;
}

int trephine_operation_event(const trephine_operation* operation, size_t index, trephine_event* event) {
  return guarded(nullptr, [&]() -> Status {
    if (event == nullptr || index >= trephine_operation_event_count(operation))
      return bad("unknown event", std::to_string(index), "below the count");
    const sim::Event& source = operation->engine().now().chronicle[index];
    event->tick = source.tick;
    event->hand = source.hand;
    for (int a = 0; a < 3; ++a) event->place[a] = source.position_world[a];
    copy_text(event->name, source.value.name());
    copy_text(event->words, source.value.words());
    return std::nullopt;
  });
}

size_t trephine_operation_measure_count(const trephine_operation* operation) {
  std::size_t count = 0;
  guarded(nullptr, [&]() -> Status {
    if (operation) count = operation->engine().measures().size();
    return std::nullopt;
  });
  return count;
}

int trephine_operation_measure(const trephine_operation* operation, size_t index, trephine_measure* measure) {
  return guarded(nullptr, [&]() -> Status {
    const auto measures = operation ? operation->engine().measures() : std::vector<sim::Measure>();
    if (measure == nullptr || index >= measures.size())
      return bad("unknown measure", std::to_string(index), "below the count");
    copy_text(measure->name, measures[index].name);
    copy_text(measure->unit, measures[index].unit);
    measure->value = measures[index].value;
    return std::nullopt;
  });
}

size_t trephine_operation_body_count(const trephine_operation* operation) {
  return operation ? operation->engine().now().world.bodies.size() : 0;
}

int trephine_operation_body(const trephine_operation* operation, size_t index, trephine_body* body) {
  if (body == nullptr || index >= trephine_operation_body_count(operation)) return TREPHINE_BAD_ARGUMENT;
  const sim::Body& source = operation->engine().now().world.bodies[index];
  body->id = source.id.value;
  body->holder = source.holder;
  body->mm3 = source.piece->mm3;
  const haptics::Placement placement = operation->engine().place_of(source);
  const glm::dquat& turn = placement.rotation;
  const double rotation[4] = {turn.w, turn.x, turn.y, turn.z};
  std::copy_n(rotation, 4, body->rotation);
  for (int a = 0; a < 3; ++a) body->position[a] = placement.position_world[a];
  const haptics::MeshTree& tree = *source.piece->tree;
  static_assert(sizeof(glm::dvec3) == 3 * sizeof(double));
  body->surface = {&tree.vertices().data()->x, tree.vertices().size(), tree.triangles().data(),
                   tree.triangles().size() / 3};
  return TREPHINE_OK;
}

int trephine_operation_changed(trephine_operation* operation, int low[3], int high[3]) {
  if (operation == nullptr || low == nullptr || high == nullptr) return 0;
  const volume::VoxelBox box = operation->replay ? operation->replay->take_changed()
                                                 : std::exchange(operation->changed, sim::k_no_voxels);
  if (box.low.x > box.high.x) return 0;
  const glm::ivec3 last = operation->engine().scene().base->size - 1;
  for (int a = 0; a < 3; ++a) {
    low[a] = std::clamp(box.low[a], 0, last[a]);
    high[a] = std::clamp(box.high[a], 0, last[a]);
  }
  return 1;
}

int trephine_operation_read(const trephine_operation* operation, const int low[3], const int high[3],
                            int16_t* intensities, trephine_error* error) {
  return guarded(error, [&]() -> Status {
    if (operation == nullptr || low == nullptr || high == nullptr || intensities == nullptr)
      return bad("an argument is missing", "NULL", "an operation, a box and room for its voxels");
    const volume::VoxelBox box{{low[0], low[1], low[2]}, {high[0], high[1], high[2]}};
    const volume::Volume& base = *operation->engine().scene().base;
    for (int a = 0; a < 3; ++a)
      if (box.low[a] < 0 || box.high[a] < box.low[a] || box.high[a] >= base.size[a])
        return bad("the box is not in the volume",
                   std::to_string(box.low[a]) + " to " + std::to_string(box.high[a]),
                   "0 <= low <= high < size");
    volume::read_operated(*operation->engine().current(), box, operation->air, intensities);
    return std::nullopt;
  });
}
