// Touch functions of the C interface.
#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <glm/geometric.hpp>
#include <memory>

#include "apps/c_api/c_parts.h"
#include "haptics/force/effects.h"
#include "haptics/methods/methods.h"
#include "haptics/walls/smooth_walls.h"
#include "volume/base/text.h"

using namespace trephine;
using c_api::bad;
using c_api::borrow_volume;
using c_api::copy_mesh;
using c_api::fail;
using c_api::guarded;
using c_api::is_valid_position;
using c_api::to_c;
using glm::dvec3;

struct trephine_surface {
  trephine_scene* scene;
  int shape;
};

struct trephine_scene {
  std::shared_ptr<volume::Volume> base;  ///< labels are set before shapes are added
  haptics::TouchScene touch;
  double requested_radius = 0;  ///< mm, requested tool radius; applied by prepare()
  std::unique_ptr<volume::Version> version;
  /// Shared with the hands. A hand keeps the method with which it was created.
  std::shared_ptr<haptics::ProxyMethod> method;
  /// Number of successful prepare() calls. Hands that were created before the last of them do not step.
  std::uint64_t generation = 0;
  bool is_prepared = false;
  std::array<trephine_surface, haptics::TouchScene::k_max_shapes> surfaces;
  // The newest motion for which a surface was queried, and its result.
  dvec3 start{0.0}, end{0.0}, point{0.0}, normal{0.0};
  bool has_motion = false;
  int hit_shape = -1, hit_side = TREPHINE_NONE;
  mutable std::atomic<int> users{
      1};  ///< number of references: by the creator until it destroys the scene, and by each hand
};

struct trephine_hand {
  const trephine_scene* scene;
  std::uint64_t generation;
  haptics::ServoScene servo_scene;  ///< of this hand alone; changed between steps
  haptics::ServoCore core;

  haptics::ServoHand& servo_hand() noexcept { return servo_scene.hands[0]; }
};

namespace {

/// Releases one reference; the last one deletes the scene.
void release(const trephine_scene* scene) noexcept {
  if (scene && scene->users.fetch_sub(1) == 1) delete scene;
}

/// Returns an error unless `shape` is the index of a window, label shape or mesh of the scene.
Status check_item(const trephine_scene* scene, int shape) {
  if (scene == nullptr) return bad("there is no scene", "NULL", "a scene from trephine_scene_create");
  if (shape < 0 || shape >= haptics::item_count(scene->touch))
    return bad("unknown shape", std::to_string(shape), "an index of a window, label or mesh");
  return std::nullopt;
}

haptics::Material& material_in(trephine_scene& scene, int shape) {
  return scene.touch.items[static_cast<std::size_t>(shape)].material;
}

/// Returns an error unless `shape` is the index of a window or label shape of the scene.
Status check_shape(const trephine_scene* scene, int shape) {
  if (scene == nullptr) return bad("there is no scene", "NULL", "a scene from trephine_scene_create");
  if (shape < 0 || shape >= haptics::item_count(scene->touch) || item_of(scene->touch, shape).is_mesh())
    return bad("unknown shape", std::to_string(shape), "an index of a window or label");
  return std::nullopt;
}

/// Returns the index of the added window or label shape, or -1.
int add_shape(trephine_scene* scene, const char* name, volume::Shape shape, trephine_error* error) noexcept {
  int index = -1;
  guarded(error, [&]() -> Status {
    if (scene == nullptr) return bad("there is no scene", "NULL", "a scene from trephine_scene_create");
    const double low = shape.low, high = shape.high;
    if (!shape.is_label() && std::isinf(low) && std::isinf(high))
      return bad("the window has no finite end", rounded_text(low) + " to " + rounded_text(high),
                 "at least one finite end");
    if (std::isnan(low) || std::isnan(high) || !(low <= high))
      return bad("the window is empty or not a number", rounded_text(low) + " to " + rounded_text(high),
                 "low <= high");
    if (shape.is_label() && scene->base->labels.is_empty())
      return bad("the scene has no labels", std::to_string(shape.label), "trephine_scene_set_labels first");
    if (scene->touch.items.size() == haptics::TouchScene::k_max_shapes)
      return bad("there are too many shapes", "a ninth shape", "at most 8");
    if (!scene->touch.items.empty() && scene->touch.items.back().is_mesh())
      return bad("a window or label comes after a mesh", name ? name : "",
                 "windows and labels first, then meshes");
    shape.name = name ? name : "";
    scene->touch.items.push_back({volume::Field(*scene->base, shape), nullptr, {}, haptics::Side::front});
    scene->is_prepared = false;
    index = static_cast<int>(scene->touch.items.size()) - 1;
    return std::nullopt;
  });
  return index;
}

volume::Shape window(double low, double high) {
  volume::Shape shape;
  shape.low = low, shape.high = high;
  return shape;
}

/// Finds the first wall of any shape on the motion, and stores it in the scene.
void cast_motion(trephine_scene& scene, const dvec3& start, const dvec3& end) noexcept {
  scene.start = start, scene.end = end;
  scene.has_motion = true;
  scene.hit_shape = -1;
  if (start == end) return;
  const volume::Frame& frame = scene.base->frame;
  haptics::ProxyCounters counters;
  const haptics::ShapeSet nothing_passable;
  haptics::SmoothWalls walls(scene.touch, *scene.version, nothing_passable, counters);
  const dvec3 a = frame.volume_from_world(start), b = frame.volume_from_world(end);
  for (const dvec3& p : {a, b})
    for (int k = 0; k < 3; ++k)
      if (!(std::abs(p[k]) < 0.25 * volume::k_traversal_limit)) return;
  haptics::ShapeSet inside;
  const auto count = static_cast<int>(base_shapes(scene.touch).size());
  for (int s = 0; s < count; ++s) inside.set(s, walls.is_solid(s, a));
  constexpr double k_before = 1e-6;  // distance of the point before the wall, voxels
  const dvec3& spacing = frame.spacing();
  const haptics::Reach reach =
      walls.reach(a, b, inside, k_before * std::min({spacing.x, spacing.y, spacing.z}));
  if (!reach.is_blocked) return;
  const dvec3 p = a + reach.t * (b - a);
  const dvec3 out = -frame.gradient_world_from_volume(walls.value_and_gradient(reach.wall, p).gradient);
  const double length = glm::length(out);
  scene.point = frame.world_from_volume(p);
  scene.normal = length > 0 ? out / length : glm::normalize(start - end);
  scene.hit_shape = reach.wall.shape;
  scene.hit_side = reach.wall.is_back ? TREPHINE_BACK : TREPHINE_FRONT;
}

}  // namespace

trephine_scene* trephine_scene_create(const int16_t* voxels, const int size[3], const double origin[3],
                                      const double axes[9], trephine_error* error) {
  std::unique_ptr<trephine_scene> scene;
  const int code = guarded(error, [&]() -> Status {
    auto base = borrow_volume(voxels, size, origin, axes);
    if (!base) return base.error();
    scene = std::make_unique<trephine_scene>();
    scene->base = base.value();
    scene->touch.base = scene->base;
    scene->version = std::make_unique<volume::Version>(scene->base);
    auto method = haptics::make_method(haptics::k_default_method);
    if (!method) return method.error();
    scene->method = std::move(method).value();
    for (std::size_t s = 0; s < scene->surfaces.size(); ++s)
      scene->surfaces[s] = {scene.get(), static_cast<int>(s)};
    return std::nullopt;
  });
  return code == TREPHINE_OK ? scene.release() : nullptr;
}

void trephine_scene_destroy(trephine_scene* scene) { release(scene); }

int trephine_scene_add_window(trephine_scene* scene, const char* name, double low, double high,
                              trephine_error* error) {
  return add_shape(scene, name, window(low, high), error);
}

int trephine_scene_set_labels(trephine_scene* scene, const uint8_t* labels, trephine_error* error) {
  return guarded(error, [&]() -> Status {
    if (scene == nullptr) return bad("there is no scene", "NULL", "a scene from trephine_scene_create");
    if (labels == nullptr) return bad("there are no labels", "NULL", "one for each voxel");
    if (!scene->touch.items.empty())
      return bad("the labels come after a shape", std::to_string(scene->touch.items.size()) + " shapes",
                 "labels first");
    scene->base->labels = Buffer<std::uint8_t>::borrow(labels, scene->base->voxels.size());
    return std::nullopt;
  });
}

int trephine_scene_add_label(trephine_scene* scene, const char* name, int label, trephine_error* error) {
  if (label < 0 || label > 255)
    return fail(error, TREPHINE_BAD_ARGUMENT,
                bad("the label is out of range", std::to_string(label), "0 to 255")),
           -1;
  volume::Shape shape;
  shape.label = label;
  return add_shape(scene, name, shape, error);
}

int trephine_scene_set_tool_radius(trephine_scene* scene, double radius, trephine_error* error) {
  return guarded(error, [&]() -> Status {
    if (scene == nullptr) return bad("there is no scene", "NULL", "a scene from trephine_scene_create");
    if (!(radius >= 0 && radius <= 6))
      return bad("the tool's radius is out of range", rounded_text(radius), "0 (a point) to 6 mm");
    scene->requested_radius = radius;
    scene->is_prepared = false;
    return std::nullopt;
  });
}

int trephine_scene_add_opacity_ramp(trephine_scene* scene, const char* name, const double* intensities,
                                    const double* opacities, size_t count, double threshold,
                                    trephine_error* error) {
  double low = 0, high = 0;
  const int code = guarded(error, [&]() -> Status {
    if (intensities == nullptr || opacities == nullptr || count < 1)
      return bad("the transfer function has no points", std::to_string(count), "one point or more");
    const auto window = haptics::window_of_opacity({intensities, count}, {opacities, count}, threshold);
    if (!window) return window.error();
    low = window.value().low, high = window.value().high;
    return std::nullopt;
  });
  return code == TREPHINE_OK ? add_shape(scene, name, window(low, high), error) : -1;
}

int trephine_scene_set_material(trephine_scene* scene, int shape, const trephine_material* material,
                                trephine_error* error) {
  return guarded(error, [&]() -> Status {
    if (Status status = check_item(scene, shape)) return status;
    if (material == nullptr) return bad("there is no material", "NULL", "a trephine_material");
    haptics::Material m = material_of(scene->touch, shape, haptics::Side::front);
    m.stiffness = material->stiffness, m.damping = material->damping;
    m.static_friction = material->static_friction, m.dynamic_friction = material->dynamic_friction;
    if (Status status = haptics::check_material(m)) return status;
    material_in(*scene, shape) = m;
    return std::nullopt;
  });
}

int trephine_scene_add_mesh(trephine_scene* scene, const char* name, const double* vertices,
                            size_t vertex_count, const uint32_t* triangles, size_t triangle_count, int mover,
                            trephine_error* error) {
  int index = -1;
  guarded(error, [&]() -> Status {
    if (scene == nullptr) return bad("there is no scene", "NULL", "a scene from trephine_scene_create");
    if (mover < -1 || mover >= haptics::TouchScene::k_max_movers)
      return bad("unknown mover", std::to_string(mover), "-1, or 0 to 7");
    if (haptics::item_count(scene->touch) >= haptics::ShapeSet::k_max)
      return bad("too many shapes and meshes", std::to_string(haptics::ShapeSet::k_max + 1), "at most 128");
    auto mesh = copy_mesh(vertices, vertex_count, triangles, triangle_count);
    if (!mesh) return mesh.error();
    auto tree = std::make_shared<const haptics::MeshTree>(std::move(mesh.value().vertices_world),
                                                          std::move(mesh.value().triangles));
    scene->touch.items.push_back(haptics::mesh_item(name ? name : "", std::move(tree)));
    scene->touch.items.back().mover = mover;
    scene->is_prepared = false;
    index = haptics::item_count(scene->touch) - 1;
    return std::nullopt;
  });
  return index;
}

int trephine_scene_set_pop_through(trephine_scene* scene, int shape, double force, double rearm,
                                   trephine_error* error) {
  return guarded(error, [&]() -> Status {
    if (Status status = check_item(scene, shape)) return status;
    haptics::Material m = material_of(scene->touch, shape, haptics::Side::front);
    m.pop_force = force, m.pop_rearm = rearm;
    if (Status status = haptics::check_material(m)) return status;
    material_in(*scene, shape) = m;
    return std::nullopt;
  });
}

int trephine_scene_set_sides(trephine_scene* scene, int shape, int sides, trephine_error* error) {
  return guarded(error, [&]() -> Status {
    if (Status status = check_item(scene, shape)) return status;
    if (sides < TREPHINE_NONE || sides > TREPHINE_BOTH)
      return bad("unknown side", std::to_string(sides), "TREPHINE_NONE, FRONT, BACK or BOTH");
    if (sides >= TREPHINE_BACK && scene->requested_radius > 0)
      return bad("contact from inside needs a tool without a radius",
                 rounded_text(scene->requested_radius) + " mm", "TREPHINE_NONE or FRONT");
    scene->touch.items[static_cast<std::size_t>(shape)].sides = static_cast<haptics::Side>(sides);
    scene->has_motion = false;
    return std::nullopt;
  });
}

int trephine_scene_set_method(trephine_scene* scene, const char* method, trephine_error* error) {
  return guarded(error, [&]() -> Status {
    if (scene == nullptr || method == nullptr)
      return bad("an argument is missing", "NULL", "a scene and a name");
    auto result = haptics::make_method(method);
    if (!result) return result.error();
    scene->method = std::move(result).value();
    scene->is_prepared = false;
    return std::nullopt;
  });
}

int trephine_scene_prepare(trephine_scene* scene, trephine_error* error) {
  return guarded(error, [&]() -> Status {
    if (scene == nullptr) return bad("there is no scene", "NULL", "a scene from trephine_scene_create");
    for (haptics::TouchItem& shape : scene->touch.items)
      if (!shape.is_mesh() && !shape.bits)
        shape.bits = std::make_shared<const volume::Occupancy>(
            volume::Occupancy::build(*scene->base, shape.field.shape()));
    // Labels and thresholded data are smoothed for methods that touch smooth solids.
    for (haptics::TouchItem& shape : scene->touch.items) shape.soft = nullptr;
    if (haptics::find_method(scene->method->name())->solid == haptics::MethodInfo::Solid::smooth)
      haptics::soften(scene->touch);
    if (Status status = haptics::set_tool_radius(scene->touch, scene->requested_radius)) return status;
    if (Status status = scene->method->prepare(scene->touch)) return status;
    scene->has_motion = false;
    ++scene->generation;
    scene->is_prepared = true;
    return std::nullopt;
  });
}

trephine_hand* trephine_hand_create(const trephine_scene* scene, double rate_hz, trephine_error* error) {
  std::unique_ptr<trephine_hand> hand;
  const int code = guarded(error, [&]() -> Status {
    if (scene == nullptr) return bad("there is no scene", "NULL", "a scene from trephine_scene_create");
    if (!(rate_hz >= 250 && rate_hz <= 10000))
      return bad("the rate is out of range", rounded_text(rate_hz), "250 to 10000 Hz");
    if (!scene->is_prepared)
      return bad("the scene is not prepared",
                 scene->touch.items.empty() ? "no shapes" : "no trephine_scene_prepare since the last change",
                 "trephine_scene_prepare before hands are created");
    haptics::ServoHand servo_hand(haptics::borrowed(scene->touch), scene->method, {*scene->version});
    hand.reset(new trephine_hand{
        scene, scene->generation, {0, {std::move(servo_hand)}}, haptics::ServoCore({}, 1 / rate_hz)});
    ++scene->users;
    return std::nullopt;
  });
  return code == TREPHINE_OK ? hand.release() : nullptr;
}

void trephine_hand_destroy(trephine_hand* hand) {
  if (hand == nullptr) return;
  const trephine_scene* scene = hand->scene;
  delete hand;
  release(scene);
}

int trephine_hand_step(trephine_hand* hand, const double position[3], trephine_touch* touch) {
  if (hand == nullptr || position == nullptr || touch == nullptr) return TREPHINE_BAD_ARGUMENT;
  if (!hand->scene->is_prepared || hand->generation != hand->scene->generation) return TREPHINE_NOT_PREPARED;
  haptics::ServoInput input;
  input.pose.position_world = {position[0], position[1], position[2]};
  const haptics::ServoRecord record = hand->core.step(hand->servo_scene, input);
  *touch = to_c(record);
  return TREPHINE_OK;
}

int trephine_hand_set_touchable(trephine_hand* hand, int shape, int is_touchable) {
  if (hand == nullptr || shape < 0 || shape >= haptics::item_count(hand->scene->touch))
    return TREPHINE_BAD_ARGUMENT;
  hand->servo_hand().set_touchable(shape, is_touchable != 0);
  return TREPHINE_OK;
}

int trephine_hand_set_ready(trephine_hand* hand, int shape, const int low[3], const int high[3]) {
  if (hand == nullptr || shape < 0 || shape >= haptics::item_count(hand->scene->touch) ||
      (low == nullptr) != (high == nullptr))
    return TREPHINE_BAD_ARGUMENT;
  if (low == nullptr)
    hand->servo_hand().set_ready(shape, true);
  else
    hand->servo_hand().set_ready(shape, {{low[0], low[1], low[2]}, {high[0], high[1], high[2]}});
  return TREPHINE_OK;
}

int trephine_hand_set_mesh_placement(trephine_hand* hand, int mover, const double position[3],
                                     const double rotation[4]) {
  if (hand == nullptr || position == nullptr || rotation == nullptr || mover < 0 ||
      mover >= haptics::TouchScene::k_max_movers || !is_valid_position(position))
    return TREPHINE_BAD_ARGUMENT;
  const glm::dquat turn(rotation[0], rotation[1], rotation[2], rotation[3]);
  const double length = glm::length(turn);
  if (!(length > 1e-6 && length < 1e6)) return TREPHINE_BAD_ARGUMENT;
  hand->servo_hand().set_placement(mover, {{position[0], position[1], position[2]}, turn / length});
  return TREPHINE_OK;
}

int trephine_hand_add_effect(trephine_hand* hand, const char* words, trephine_error* error) {
  return guarded(error, [&]() -> Status {
    if (hand == nullptr || words == nullptr) return bad("an argument is missing", "NULL", "hand and effect");
    auto effect = haptics::parse_effect(words);
    if (!effect) return effect.error();
    auto laws = hand->servo_hand().laws ? std::make_shared<haptics::LawSet>(*hand->servo_hand().laws)
                                        : std::make_shared<haptics::LawSet>();
    auto law = haptics::law_of(effect.value(), static_cast<std::uint32_t>(laws->laws().size()));
    if (!law) return law.error();
    if (Status status = laws->add(std::move(law).value())) return status;
    hand->servo_hand().laws = std::move(laws);
    return std::nullopt;
  });
}

void trephine_hand_reset(trephine_hand* hand) {
  if (hand != nullptr) hand->core.reset();
}

trephine_surface* trephine_surface_get(trephine_scene* scene, int shape, trephine_error* error) {
  const int code = guarded(error, [&]() -> Status {
    if (Status status = check_shape(scene, shape)) return status;
    if (!scene->is_prepared)
      return bad("the scene is not prepared", "no trephine_scene_prepare since the last change",
                 "trephine_scene_prepare before trephine_surface_get");
    if (scene->touch.tool->radius() > 0)
      return bad("surfaces need a tool without a radius", rounded_text(scene->touch.tool->radius()) + " mm",
                 "a tool radius of 0");
    return std::nullopt;
  });
  return code == TREPHINE_OK ? &scene->surfaces[static_cast<std::size_t>(shape)] : nullptr;
}

int trephine_intersect_surface(const double start[3], const double end[3], double point[3], double normal[3],
                               int* side, void* user) {
  auto* surface = static_cast<trephine_surface*>(user);
  if (surface == nullptr || start == nullptr || end == nullptr || !is_valid_position(start) ||
      !is_valid_position(end))
    return 0;
  trephine_scene& scene = *surface->scene;
  if (!scene.is_prepared) return 0;
  const dvec3 a(start[0], start[1], start[2]), b(end[0], end[1], end[2]);
  if (!scene.has_motion || scene.start != a || scene.end != b) cast_motion(scene, a, b);
  if (scene.hit_shape != surface->shape) return 0;
  for (int i = 0; i < 3; ++i) {
    if (point != nullptr) point[i] = scene.point[i];
    if (normal != nullptr) normal[i] = scene.normal[i];
  }
  if (side != nullptr) *side = scene.hit_side;
  return 1;
}
