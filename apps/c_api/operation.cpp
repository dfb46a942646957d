// Functions of operations of the C interface.
#include <algorithm>
#include <cmath>
#include <cstring>
#include <glm/geometric.hpp>
#include <optional>

#include "apps/c_api/device_handle.h"

using namespace trephine;
using c_api::bad;
using c_api::fail;
using c_api::guarded;

/// An operation with the arrays to which its last results refer.
struct trephine_operation {
  Operation operation;
  std::vector<Pose> poses;
  std::vector<glm::dvec3> torques;                         ///< N mm, of the last step, per hand
  std::optional<std::vector<Body>> bodies = std::nullopt;  ///< of the current state; nullopt: not queried yet
  Surface surface = {};

  explicit trephine_operation(Operation opened)
      : operation(std::move(opened)),
        poses(operation.hand_count()),
        torques(operation.hand_count(), glm::dvec3(0)) {}
  const std::vector<Body>& current_bodies() {
    if (!bodies) bodies = operation.bodies();
    return *bodies;
  }
};

namespace {

Result<std::vector<std::shared_ptr<const Volume>>> borrow_volumes(const trephine_voxels* volumes,
                                                                  std::size_t count) {
  if (count > 0 && volumes == nullptr) return bad("an argument is missing", "NULL", "volumes");
  std::vector<std::shared_ptr<const Volume>> result;
  for (std::size_t v = 0; v < count; ++v) {
    const trephine_voxels& input = volumes[v];
    auto volume = c_api::borrow_volume(input.intensities, input.size, input.origin, input.axes);
    if (!volume) return volume.error();
    volume.value()->is_hounsfield = input.is_hounsfield != 0;
    if (input.labels)
      volume.value()->labels = Buffer<std::uint8_t>::borrow(input.labels, volume.value()->voxels.size());
    result.push_back(std::move(volume).value());
  }
  return result;
}

std::string text_or_empty(const char* text) { return text ? text : ""; }

Recording recording_of(const char* file, int is_embedding) {
  return {text_or_empty(file), is_embedding != 0, "trephine " TREPHINE_VERSION " (C interface)"};
}

Result<Operation> begin(const trephine_start* start) {
  if (start == nullptr) return bad("an argument is missing", "NULL", "a trephine_start");
  if (start->scene == nullptr || start->volume_count < 1 ||
      (start->model_count > 0 && start->models == nullptr))
    return bad("an argument is missing", "NULL", "a scene, at least one volume, and model_count models");
  auto volumes = borrow_volumes(start->volumes, start->volume_count);
  if (!volumes) return volumes.error();
  std::vector<Surface> models;
  for (std::size_t m = 0; m < start->model_count; ++m) {
    const trephine_model& model = start->models[m];
    auto copy = c_api::copy_mesh(model.vertices, model.vertex_count, model.triangles, model.triangle_count);
    if (!copy) return copy.error();
    models.push_back(std::move(copy).value());
  }
  return Operation::open_scene(start->scene, std::move(volumes).value(), std::move(models),
                               recording_of(start->record, start->is_embedding));
}

Result<Operation> open_scan(const trephine_scan* scan) {
  if (scan == nullptr || scan->path == nullptr || (scan->tool_count > 0 && scan->tools == nullptr))
    return bad("an argument is missing", "NULL", "a trephine_scan with a path, and tool_count tools");
  OperationOptions options;
  options.hands.clear();
  for (std::size_t t = 0; t < scan->tool_count; ++t) {
    const trephine_tool& tool = scan->tools[t];
    options.hands.push_back({.instrument = text_or_empty(tool.instrument),
                             .parameters = text_or_empty(tool.parameters),
                             .tool_radius = tool.tool_radius,
                             .method = text_or_empty(tool.method)});
  }
  options.window = text_or_empty(scan->window);
  options.label = text_or_empty(scan->label);
  options.uses_plan = scan->uses_plan != 0;
  if (scan->device_count > 0 && scan->devices == nullptr)
    return bad("an argument is missing", "NULL", "device_count devices");
  for (std::size_t d = 0; d < scan->device_count; ++d) {
    if (scan->devices[d] == nullptr) return bad("an argument is missing", "NULL", "an open device");
    options.devices.push_back(scan->devices[d]->device.capabilities());
  }
  if (scan->rate_hz != 0) options.rate_hz = scan->rate_hz;
  options.recording = recording_of(scan->record, scan->is_embedding);
  return Operation::open(scan->path, options);
}

Result<Operation> open_session(const char* session, const trephine_voxels* volumes, std::size_t count) {
  if (session == nullptr) return bad("an argument is missing", "NULL", "a session's file");
  if (count == 0) return Operation::reopen(session);
  auto borrowed = borrow_volumes(volumes, count);
  if (!borrowed) return borrowed.error();
  return Operation::reopen(session, std::move(borrowed).value());
}

/// Returns the operation that `open` opens, or NULL.
template <class Open>
trephine_operation* make(trephine_error* error, Open&& open) noexcept {
  std::unique_ptr<trephine_operation> result;
  const int code = guarded(error, [&]() -> Status {
    Result<Operation> opened = open();
    if (!opened) return opened.error();
    result = std::make_unique<trephine_operation>(std::move(opened).value());
    return std::nullopt;
  });
  return code == TREPHINE_OK ? result.release() : nullptr;
}

/// Runs `work` on the operation. Errors of the kinds `refused` and `different` have codes of their own; other
/// errors have the code `otherwise`.
template <class Work>
int apply(trephine_operation* operation, trephine_error* error, int otherwise, Work&& work) noexcept {
  Status failed;
  const int code = guarded(error, [&]() -> Status {
    if (operation == nullptr) return bad("there is no operation", "NULL", "an operation");
    failed = work(operation->operation);
    return std::nullopt;
  });
  if (!failed) return code;
  return fail(error,
              failed->kind == ErrorKind::refused     ? TREPHINE_REFUSED
              : failed->kind == ErrorKind::different ? TREPHINE_DIFFERENT
                                                     : otherwise,
              *failed);
}

Pose pose_of(const trephine_pose& input) noexcept {
  Pose pose;
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

glm::dvec3 vector_of(const double v[3]) noexcept { return {v[0], v[1], v[2]}; }

trephine_model to_c(const Surface& surface) noexcept {
  static_assert(sizeof(glm::dvec3) == 3 * sizeof(double));
  return {surface.vertices_world.empty() ? nullptr : &surface.vertices_world.data()->x,
          surface.vertices_world.size(), surface.triangles.data(), surface.triangles.size() / 3};
}

}  // namespace

uint32_t trephine_abi_version(void) { return TREPHINE_ABI_VERSION; }

int trephine_load_module(const char* path, trephine_error* error) {
  return guarded(error, [&]() -> Status {
    if (path == nullptr) return bad("an argument is missing", "NULL", "the path of a module");
    return load_module(path);
  });
}

trephine_operation* trephine_operation_begin(const trephine_start* start, trephine_error* error) {
  return make(error, [&] { return begin(start); });
}
trephine_operation* trephine_operation_open_scan(const trephine_scan* scan, trephine_error* error) {
  return make(error, [&] { return open_scan(scan); });
}
trephine_operation* trephine_operation_open(const char* session, const trephine_voxels* volumes,
                                            size_t volume_count, trephine_error* error) {
  return make(error, [&] { return open_session(session, volumes, volume_count); });
}
trephine_operation* trephine_operation_reopen(const char* session, const char* scan, trephine_error* error) {
  return make(error, [&]() -> Result<Operation> {
    if (session == nullptr || scan == nullptr)
      return bad("an argument is missing", "NULL", "a session's file, and the path of its scan");
    return Operation::reopen(session, scan);
  });
}
void trephine_operation_destroy(trephine_operation* operation) { delete operation; }

int trephine_operation_step(trephine_operation* operation, const trephine_pose* poses,
                            trephine_touch* touches, trephine_error* error) {
  return apply(operation, error, TREPHINE_BAD_ARGUMENT, [&](Operation& on) -> Status {
    if (poses == nullptr) return bad("there are no poses", "NULL", "one pose per hand");
    for (std::size_t h = 0; h < operation->poses.size(); ++h) operation->poses[h] = pose_of(poses[h]);
    const auto stepped = on.step(operation->poses);
    if (!stepped) return stepped.error();
    operation->bodies.reset();
    std::transform(stepped.value().begin(), stepped.value().end(), operation->torques.begin(),
                   [](const Touch& touch) { return touch.torque_world; });
    if (touches)
      std::transform(stepped.value().begin(), stepped.value().end(), touches,
                     [](const Touch& touch) { return c_api::to_c(touch); });
    return std::nullopt;
  });
}

int trephine_operation_torques(const trephine_operation* operation, double (*torques)[3]) {
  if (operation == nullptr || torques == nullptr) return TREPHINE_BAD_ARGUMENT;
  for (std::size_t h = 0; h < operation->torques.size(); ++h)
    for (int a = 0; a < 3; ++a) torques[h][a] = operation->torques[h][a];
  return TREPHINE_OK;
}

int trephine_operation_command(trephine_operation* operation, int hand, const char* command,
                               const char* words, trephine_error* error) {
  return apply(operation, error, TREPHINE_BAD_ARGUMENT, [&](Operation& on) -> Status {
    if (command == nullptr) return bad("there is no command", "NULL", "a name");
    operation->bodies.reset();
    return on.command(command, words ? words : "", hand);
  });
}

int trephine_operation_reset(trephine_operation* operation) {
  return apply(operation, nullptr, TREPHINE_BAD_ARGUMENT, [](Operation& on) { return on.reset(); });
}

int trephine_operation_end(trephine_operation* operation, trephine_error* error) {
  // The caller must not end a read-only operation: that is a bad argument. A recording that fails is not the
  // caller's mistake.
  const bool is_read_only = operation && operation->operation.is_read_only();
  return apply(operation, error, is_read_only ? TREPHINE_BAD_ARGUMENT : TREPHINE_FAILED,
               [](Operation& on) { return on.end(); });
}

int trephine_operation_go_to(trephine_operation* operation, uint64_t tick, trephine_error* error) {
  return apply(operation, error, TREPHINE_BAD_ARGUMENT, [&](Operation& on) {
    operation->bodies.reset();
    return on.go_to(tick);
  });
}

int trephine_operation_verify(trephine_operation* operation, trephine_error* error) {
  const bool is_recorded = operation && operation->operation.is_recorded();
  return apply(operation, error, is_recorded ? TREPHINE_FAILED : TREPHINE_BAD_ARGUMENT, [&](Operation& on) {
    operation->bodies.reset();
    return on.verify();
  });
}

int trephine_operation_is_whole(const trephine_operation* operation) {
  return operation && operation->operation.is_whole();
}
uint64_t trephine_operation_tick(const trephine_operation* operation) {
  return operation ? operation->operation.tick() : 0;
}
uint64_t trephine_operation_tick_count(const trephine_operation* operation) {
  return operation ? operation->operation.tick_count() : 0;
}
size_t trephine_operation_hand_count(const trephine_operation* operation) {
  return operation ? operation->operation.hand_count() : 0;
}

size_t trephine_operation_scene(const trephine_operation* operation, char* text, size_t capacity) {
  std::string scene;
  if (guarded(nullptr, [&]() -> Status {
        if (operation) scene = operation->operation.scene();
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
  apply(operation, nullptr, TREPHINE_BAD_ARGUMENT, [&](Operation& on) -> Status {
    hash = on.hash();
    return std::nullopt;
  });
  return hash;
}

size_t trephine_operation_event_count(const trephine_operation* operation) {
  return operation ? operation->operation.event_count() : 0;
}

int trephine_operation_event(const trephine_operation* operation, size_t index, trephine_event* event) {
  return guarded(nullptr, [&]() -> Status {
    if (event == nullptr || index >= trephine_operation_event_count(operation))
      return bad("unknown event", std::to_string(index), "below the count");
    const Event& source = operation->operation.event(index);
    event->tick = source.tick;
    event->hand = source.hand;
    for (int a = 0; a < 3; ++a) event->position[a] = source.position_world[a];
    copy_text(event->name, source.value.name());
    copy_text(event->words, source.value.words());
    return std::nullopt;
  });
}

size_t trephine_operation_measure_count(const trephine_operation* operation) {
  std::size_t count = 0;
  guarded(nullptr, [&]() -> Status {
    if (operation) count = operation->operation.measures().size();
    return std::nullopt;
  });
  return count;
}

int trephine_operation_measure(const trephine_operation* operation, size_t index, trephine_measure* measure) {
  return guarded(nullptr, [&]() -> Status {
    const auto measures = operation ? operation->operation.measures() : std::vector<Measure>();
    if (measure == nullptr || index >= measures.size())
      return bad("unknown measure", std::to_string(index), "below the count");
    copy_text(measure->name, measures[index].name);
    copy_text(measure->unit, measures[index].unit);
    measure->value = measures[index].value;
    return std::nullopt;
  });
}

size_t trephine_operation_body_count(trephine_operation* operation) {
  std::size_t count = 0;
  guarded(nullptr, [&]() -> Status {
    if (operation) count = operation->current_bodies().size();
    return std::nullopt;
  });
  return count;
}

int trephine_operation_body(trephine_operation* operation, size_t index, trephine_body* body) {
  return guarded(nullptr, [&]() -> Status {
    if (body == nullptr || index >= trephine_operation_body_count(operation))
      return bad("unknown body", std::to_string(index), "below the count");
    const Body& source = operation->current_bodies()[index];
    body->id = source.id;
    body->holder = source.holder;
    body->mm3 = source.mm3;
    const double rotation[4] = {source.rotation.w, source.rotation.x, source.rotation.y, source.rotation.z};
    std::copy_n(rotation, 4, body->rotation);
    for (int a = 0; a < 3; ++a) body->position[a] = source.position_world[a];
    body->surface = to_c(*source.surface);
    return std::nullopt;
  });
}

int trephine_operation_changed(trephine_operation* operation, int low[3], int high[3]) {
  if (operation == nullptr || low == nullptr || high == nullptr) return 0;
  const std::optional<VoxelRange> range = operation->operation.take_changed();
  if (!range) return 0;
  for (int a = 0; a < 3; ++a) low[a] = range->low[a], high[a] = range->high[a];
  return 1;
}

int trephine_operation_read(const trephine_operation* operation, const int low[3], const int high[3],
                            int16_t* intensities, trephine_error* error) {
  return guarded(error, [&]() -> Status {
    if (operation == nullptr || low == nullptr || high == nullptr || intensities == nullptr)
      return bad("an argument is missing", "NULL", "an operation, a box and room for its voxels");
    const auto values = operation->operation.read({{low[0], low[1], low[2]}, {high[0], high[1], high[2]}});
    if (!values) return values.error();
    std::copy(values.value().begin(), values.value().end(), intensities);
    return std::nullopt;
  });
}

int trephine_operation_surface(trephine_operation* operation, size_t structure, trephine_model* surface,
                               trephine_error* error) {
  return apply(operation, error, TREPHINE_BAD_ARGUMENT, [&](Operation& on) -> Status {
    if (surface == nullptr) return bad("an argument is missing", "NULL", "a trephine_model");
    auto built = on.surface(structure);
    if (!built) return built.error();
    operation->surface = std::move(built).value();
    *surface = to_c(operation->surface);
    return std::nullopt;
  });
}

int trephine_operation_slice(const trephine_operation* operation, const double middle[3],
                             const double right[3], const double up[3], double pixel, int columns, int rows,
                             int16_t* intensities, trephine_error* error) {
  return guarded(error, [&]() -> Status {
    if (operation == nullptr || middle == nullptr || right == nullptr || up == nullptr ||
        intensities == nullptr)
      return bad("an argument is missing", "NULL", "an operation, a plane and room for its pixels");
    const auto image = operation->operation.slice(
        {vector_of(middle), vector_of(right), vector_of(up), pixel, columns, rows});
    if (!image) return image.error();
    std::copy(image.value().pixels.begin(), image.value().pixels.end(), intensities);
    return std::nullopt;
  });
}

int trephine_operation_xray(trephine_operation* operation, const double isocentre[3], double primary,
                            double secondary, double pixel, int columns, int rows, uint8_t* greys,
                            trephine_error* error) {
  return apply(operation, error, TREPHINE_BAD_ARGUMENT, [&](Operation& on) -> Status {
    if (isocentre == nullptr || greys == nullptr)
      return bad("an argument is missing", "NULL", "an isocentre and room for the pixels");
    const auto image = on.xray({vector_of(isocentre), primary, secondary, pixel, columns, rows});
    if (!image) return image.error();
    std::copy(image.value().pixels.begin(), image.value().pixels.end(), greys);
    return std::nullopt;
  });
}
