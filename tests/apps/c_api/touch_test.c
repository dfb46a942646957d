/* Touch in C; with TREPHINE_LOAD the library is loaded at run time, as a game engine does. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "apps/c_api/trephine.h"
#include "tests/scenes/c_check.h"

#ifdef TREPHINE_LOAD
#include <dlfcn.h>
/* clang-format off */
#define FUNCTIONS(X)                                                                                                   \
  X(trephine_abi_version) X(trephine_scene_create) X(trephine_scene_destroy) X(trephine_scene_add_window)              \
  X(trephine_scene_add_opacity_ramp) X(trephine_scene_set_material) X(trephine_scene_set_sides)                        \
  X(trephine_scene_set_method) X(trephine_scene_prepare) X(trephine_hand_create) X(trephine_hand_destroy)              \
  X(trephine_scene_add_mesh) X(trephine_scene_set_pop_through) X(trephine_hand_set_touchable) X(trephine_hand_set_ready)                          \
  X(trephine_hand_set_mesh_placement) X(trephine_hand_add_effect)                                                      \
  X(trephine_hand_step) X(trephine_hand_reset) X(trephine_surface_get) X(trephine_intersect_surface)                              \
  X(trephine_scene_set_labels) X(trephine_scene_add_label) X(trephine_scene_set_tool_radius)
/* clang-format on */
#define DECLARE(name) static __typeof__(&name) p_##name;
FUNCTIONS(DECLARE)
#define FETCH(name)                                         \
  {                                                         \
    void* address = dlsym(library, #name);                  \
    if (!address) return printf("missing: %s\n", #name), 1; \
    memcpy(&p_##name, &address, sizeof address);            \
  }
#define trephine_abi_version p_trephine_abi_version
#define trephine_scene_create p_trephine_scene_create
#define trephine_scene_destroy p_trephine_scene_destroy
#define trephine_scene_add_window p_trephine_scene_add_window
#define trephine_scene_add_opacity_ramp p_trephine_scene_add_opacity_ramp
#define trephine_scene_set_material p_trephine_scene_set_material
#define trephine_scene_set_sides p_trephine_scene_set_sides
#define trephine_scene_set_method p_trephine_scene_set_method
#define trephine_scene_prepare p_trephine_scene_prepare
#define trephine_hand_create p_trephine_hand_create
#define trephine_hand_destroy p_trephine_hand_destroy
#define trephine_hand_step p_trephine_hand_step
#define trephine_hand_reset p_trephine_hand_reset
#define trephine_surface_get p_trephine_surface_get
#define trephine_intersect_surface p_trephine_intersect_surface
#define trephine_scene_add_mesh p_trephine_scene_add_mesh
#define trephine_scene_set_pop_through p_trephine_scene_set_pop_through
#define trephine_hand_set_touchable p_trephine_hand_set_touchable
#define trephine_hand_set_ready p_trephine_hand_set_ready
#define trephine_hand_set_mesh_placement p_trephine_hand_set_mesh_placement
#define trephine_hand_add_effect p_trephine_hand_add_effect
#define trephine_scene_set_labels p_trephine_scene_set_labels
#define trephine_scene_add_label p_trephine_scene_add_label
#define trephine_scene_set_tool_radius p_trephine_scene_set_tool_radius
#endif

enum { N = 48 };
static int16_t voxels[N * N * N];
static uint8_t labels[N * N * N];

/* A ball of 15 mm radius around the middle, of two tissues: denser inside 8 mm. */
static void make_ball(void) {
  for (int z = 0; z < N; ++z)
    for (int y = 0; y < N; ++y)
      for (int x = 0; x < N; ++x) {
        const double dx = x - 23.5, dy = y - 23.5, dz = z - 23.5, r = sqrt(dx * dx + dy * dy + dz * dz);
        const double hu = r < 8 ? 1500 : 600 - 300 * (r - 15);
        voxels[(z * N + y) * N + x] =
            (int16_t)fmax(-1000, fmin(1500, hu < 0 ? hu : (r < 8 ? 1500 : fmin(hu, 900))));
      }
}

int main(int argc, char** argv) {
#ifdef TREPHINE_LOAD
  if (argc < 2) return printf("usage: %s LIBRARY\n", argv[0]), 2;
  void* library = dlopen(argv[1], RTLD_NOW | RTLD_LOCAL);
  if (!library) return printf("%s\n", dlerror()), 1;
  FUNCTIONS(FETCH)
#else
  (void)argc, (void)argv;
#endif
  CHECK(trephine_abi_version() == TREPHINE_ABI_VERSION);
  make_ball();
  const int size[3] = {N, N, N};
  const double origin[3] = {-23.5, -23.5, -23.5}, axes[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
  trephine_error error;

  /* Bad input is reported with a message. */
  const int empty[3] = {N, 0, N};
  CHECK(trephine_scene_create(voxels, empty, origin, axes, &error) == NULL);
  CHECK(error.code == TREPHINE_BAD_ARGUMENT && strstr(error.text, "size") != NULL);
  const double flat[9] = {1, 0, 0, 1, 0, 0, 0, 0, 1};
  CHECK(trephine_scene_create(voxels, size, origin, flat, NULL) == NULL);
  CHECK(trephine_scene_create(NULL, size, origin, axes, &error) == NULL);

  trephine_scene* scene = trephine_scene_create(voxels, size, origin, axes, &error);
  CHECK(scene != NULL && error.code == TREPHINE_OK);
  CHECK(trephine_hand_create(scene, 1000, &error) == NULL); /* not prepared */
  CHECK(strstr(error.text, "prepared") != NULL);
  const int soft = trephine_scene_add_window(scene, "soft", 600, 1200, &error);
  const double hu[4] = {-1000, 1100, 1300, 3000}, opacity[4] = {0, 0, 1, 1};
  const int hard = trephine_scene_add_opacity_ramp(scene, "hard", hu, opacity, 4, 0.5, &error);
  CHECK(soft == 0 && hard == 1);
  CHECK(trephine_scene_add_window(scene, "none", 10, 5, &error) == -1);
  CHECK(trephine_scene_add_window(scene, "everything", -INFINITY, INFINITY, &error) == -1);
  const double two[4] = {1, 0, 1, 0};
  CHECK(trephine_scene_add_opacity_ramp(scene, "two", hu, two, 4, 0.5, &error) == -1);
  CHECK(strstr(error.text, "interval") != NULL);
  trephine_material material = {1.0, 0.0, 0.0, 0.0};
  CHECK(trephine_scene_set_material(scene, soft, &material, &error) == TREPHINE_OK);
  material.stiffness = -1;
  CHECK(trephine_scene_set_material(scene, soft, &material, &error) == TREPHINE_BAD_ARGUMENT);
  CHECK(strstr(error.text, "stiffness") != NULL);
  CHECK(trephine_scene_set_material(scene, 7, &material, NULL) == TREPHINE_BAD_ARGUMENT);
  CHECK(trephine_scene_set_method(scene, "subvoxels", &error) == TREPHINE_BAD_ARGUMENT);
  CHECK(strstr(error.text, "implicit") != NULL);
  CHECK(trephine_scene_set_sides(scene, hard, 4, &error) == TREPHINE_BAD_ARGUMENT);
  CHECK(trephine_scene_prepare(scene, &error) == TREPHINE_OK);

  /* A hand 2 mm below the surface of the ball is pushed back with 2 N. */
  CHECK(trephine_hand_create(scene, 10, &error) == NULL);
  trephine_hand* hand = trephine_hand_create(scene, 1000, &error);
  CHECK(hand != NULL);
  trephine_touch touch;
  for (int i = 0; i <= 600; ++i) {
    const double depth = -5 + 7 * fmin(1, i / 300.0), position[3] = {0, 0, 15 - depth};
    CHECK(trephine_hand_step(hand, position, &touch) == TREPHINE_OK);
  }
  CHECK(touch.has_contact == 1 && touch.shape == soft && touch.side == TREPHINE_FRONT);
  CHECK(fabs(touch.proxy[2] - 15) < 0.1 && fabs(touch.force[2] - 2) < 0.1 && touch.normal[2] > 0.99);
  const double nowhere[3] = {NAN, 0, 0};
  CHECK(trephine_hand_step(hand, nowhere, &touch) == TREPHINE_OK);
  CHECK(touch.faults != 0 && touch.force[0] == 0 && touch.force[1] == 0 && touch.force[2] == 0);
  CHECK(trephine_hand_step(NULL, nowhere, &touch) == TREPHINE_BAD_ARGUMENT);
  trephine_hand_reset(hand);

  /* Surfaces as custom shapes of an engine, which are intersected in turn: one of them is hit. */
  trephine_surface* outer = trephine_surface_get(scene, soft, &error);
  trephine_surface* inner = trephine_surface_get(scene, hard, &error);
  CHECK(outer != NULL && inner != NULL && trephine_surface_get(scene, 5, &error) == NULL);
  double point[3], normal[3];
  int side = 0;
  const double above[3] = {1, 2, 22}, below[3] = {1, 2, 10};
  CHECK(trephine_intersect_surface(above, below, point, normal, &side, outer) == 1);
  CHECK(fabs(sqrt(point[0] * point[0] + point[1] * point[1] + point[2] * point[2]) - 15) < 0.1);
  CHECK(side == TREPHINE_FRONT && normal[2] > 0.9);
  CHECK(trephine_intersect_surface(above, below, point, normal, &side, inner) == 0);
  /* From within the soft shell downward, the hard surface is hit. */
  const double shell[3] = {0, 0, 12}, core[3] = {0, 0, 2};
  CHECK(trephine_intersect_surface(shell, core, point, normal, &side, outer) == 0);
  CHECK(trephine_intersect_surface(shell, core, point, normal, &side, inner) == 1);
  CHECK(fabs(point[2] - 8) < 1);
  CHECK(trephine_intersect_surface(above, above, point, normal, &side, outer) == 0);
  CHECK(trephine_intersect_surface(above, nowhere, point, normal, &side, outer) == 0);
  CHECK(trephine_intersect_surface(above, below, point, normal, NULL, NULL) == 0);
  /* A hit can be the start of the next query: no step enters the solid. */
  CHECK(trephine_intersect_surface(above, below, point, normal, &side, outer) == 1);
  double again[3];
  memcpy(again, point, sizeof again);
  CHECK(trephine_intersect_surface(again, below, point, normal, &side, outer) == 1);
  CHECK(fabs(point[2] - again[2]) < 1e-4);

  /* A removed side is not hit any more; a hand made before a change of the method does not step. */
  CHECK(trephine_scene_set_sides(scene, soft, TREPHINE_NONE, &error) == TREPHINE_OK);
  CHECK(trephine_intersect_surface(above, below, point, normal, &side, outer) == 0);
  CHECK(trephine_scene_set_method(scene, "implicit", &error) == TREPHINE_OK);
  CHECK(trephine_hand_step(hand, above, &touch) == TREPHINE_NOT_PREPARED);
  CHECK(trephine_scene_prepare(scene, &error) == TREPHINE_OK);
  CHECK(trephine_hand_step(hand, above, &touch) == TREPHINE_NOT_PREPARED);
  trephine_hand* newer = trephine_hand_create(scene, 1000, &error);
  CHECK(newer != NULL && trephine_hand_step(newer, above, &touch) == TREPHINE_OK);
  trephine_hand_destroy(newer);

  /* A model that moves through the ball: a plate that lifts the tool. */
  const double corners[12] = {-30, -30, 0, 30, -30, 0, 30, 30, 0, -30, 30, 0};
  const uint32_t plate[6] = {0, 1, 2, 0, 2, 3}, wrong[3] = {0, 1, 7};
  CHECK(trephine_scene_set_sides(scene, soft, TREPHINE_FRONT, &error) == TREPHINE_OK);
  CHECK(trephine_scene_add_mesh(scene, "bad", corners, 4, wrong, 1, -1, &error) == -1);
  CHECK(trephine_scene_add_mesh(scene, "bad", corners, 4, plate, 2, 9, &error) == -1);
  const int lift = trephine_scene_add_mesh(scene, "plate", corners, 4, plate, 2, 0, &error);
  CHECK(lift == 2 && trephine_scene_add_window(scene, "late", 1, 2, &error) == -1);
  CHECK(trephine_scene_prepare(scene, &error) == TREPHINE_BAD_ARGUMENT &&
        strstr(error.text, "scene") != NULL);
  CHECK(trephine_scene_set_method(scene, "scene", &error) == TREPHINE_OK);
  CHECK(trephine_scene_set_pop_through(scene, soft, -1, 0, &error) == TREPHINE_BAD_ARGUMENT);
  CHECK(trephine_scene_set_pop_through(scene, soft, 1.5, 2, &error) == TREPHINE_OK);
  CHECK(trephine_scene_prepare(scene, &error) == TREPHINE_OK);
  trephine_hand* lifted = trephine_hand_create(scene, 1000, &error);
  CHECK(lifted != NULL);
  const double level[4] = {1, 0, 0, 0}, none[4] = {0, 0, 0, 0};
  double rest[3] = {0, 0, 16}, place[3] = {0, 0, 10};
  CHECK(trephine_hand_set_mesh_placement(lifted, 0, place, none) == TREPHINE_BAD_ARGUMENT);
  CHECK(trephine_hand_set_mesh_placement(lifted, 9, place, level) == TREPHINE_BAD_ARGUMENT);
  CHECK(trephine_hand_set_mesh_placement(lifted, 0, place, level) == TREPHINE_OK);
  CHECK(trephine_hand_step(lifted, rest, &touch) == TREPHINE_OK && !touch.has_contact);
  for (int i = 0; i <= 200; ++i) {
    place[2] = 10 + 0.04 * i;
    CHECK(trephine_hand_set_mesh_placement(lifted, 0, place, level) == TREPHINE_OK);
    CHECK(trephine_hand_step(lifted, rest, &touch) == TREPHINE_OK);
  }
  CHECK(touch.has_contact && touch.shape == lift && fabs(touch.proxy[2] - 18) < 1e-3);
  CHECK(trephine_hand_set_touchable(lifted, lift, 0) == TREPHINE_OK);
  CHECK(trephine_hand_set_touchable(lifted, 7, 0) == TREPHINE_BAD_ARGUMENT);
  {
    const int low[3] = {0, 0, 0}, high[3] = {1, 1, 1};
    CHECK(trephine_hand_set_ready(lifted, 0, low, high) == TREPHINE_OK);
    CHECK(trephine_hand_set_ready(lifted, 0, NULL, NULL) == TREPHINE_OK);
    CHECK(trephine_hand_set_ready(lifted, 0, low, NULL) == TREPHINE_BAD_ARGUMENT);
    CHECK(trephine_hand_set_ready(lifted, 7, low, high) == TREPHINE_BAD_ARGUMENT);
  }
  CHECK(trephine_hand_step(lifted, rest, &touch) == TREPHINE_OK && !touch.has_contact);
  /* The hand presses into the ball until its proxy pops through. */
  double strongest = 0;
  for (int i = 0; i <= 600; ++i) {
    rest[2] = 16 - 0.01 * i;
    CHECK(trephine_hand_step(lifted, rest, &touch) == TREPHINE_OK);
    strongest = fmax(strongest, touch.force[2]);
  }
  CHECK(strongest > 1.3 && strongest < 1.7 && !touch.has_contact);
  CHECK(trephine_hand_add_effect(lifted, "hum", &error) == TREPHINE_BAD_ARGUMENT &&
        strstr(error.text, "viscous"));
  CHECK(trephine_hand_add_effect(lifted, "constant force=0,0,0.5", &error) == TREPHINE_OK);
  for (int i = 0; i <= 200; ++i) CHECK(trephine_hand_step(lifted, rest, &touch) == TREPHINE_OK);
  CHECK(fabs(touch.force[2] - 0.5) < 1e-6);
  trephine_hand_destroy(lifted);

  trephine_hand_destroy(hand);
  trephine_hand_destroy(NULL);
  trephine_scene_destroy(scene);
  trephine_scene_destroy(NULL);

  /* The contact with a thresholded ball is smooth; a hand outlives the scene that it was made from. */
  for (int i = 0; i < N * N * N; ++i) {
    const double x = i % N - 23.5, y = i / N % N - 23.5, z = i / (N * N) - 23.5;
    voxels[i] = x * x + y * y + z * z < 18.0 * 18.0 ? 1 : 0;
  }
  const int ball_size[3] = {N, N, N};
  const double ball_origin[3] = {-23.5, -23.5, -23.5}, ball_axes[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
  trephine_scene* mask = trephine_scene_create(voxels, ball_size, ball_origin, ball_axes, &error);
  CHECK(mask != NULL && trephine_scene_add_window(mask, "mask", 1, INFINITY, &error) == 0);
  CHECK(trephine_scene_prepare(mask, &error) == TREPHINE_OK);
  trephine_hand* on_mask = trephine_hand_create(mask, 1000, &error);
  CHECK(on_mask != NULL);
  trephine_scene_destroy(mask);
  double square = 0;
  int count = 0;
  for (int i = 0; i < 3000; ++i) {
    const double angle = 0.002 * i, r = i < 300 ? 21 - 0.013 * i : 17.1;
    const double at[3] = {r * cos(angle) * 0.9, r * sin(angle), r * cos(angle) * 0.43589};
    CHECK(trephine_hand_step(on_mask, at, &touch) == TREPHINE_OK);
    if (i < 500 || !touch.has_contact) continue;
    const double dot = (touch.normal[0] * at[0] + touch.normal[1] * at[1] + touch.normal[2] * at[2]) / r;
    square += 1 - fmin(1, dot * dot);
    ++count;
  }
  CHECK(count > 2000);
  CHECK(57.3 * sqrt(square / count) < 4); /* degrees RMS; 14 on the faces of voxels */
  trephine_hand_destroy(on_mask);

  /* A label is touched with a ball of 2 mm radius, whose centre rests 2 mm off the surface. */
  for (int i = 0; i < N * N * N; ++i) labels[i] = voxels[i] ? 3 : 0;
  trephine_scene* labelled = trephine_scene_create(voxels, ball_size, ball_origin, ball_axes, &error);
  CHECK(trephine_scene_add_label(labelled, "dura", 3, &error) == -1 && strstr(error.text, "no labels"));
  CHECK(trephine_scene_set_labels(labelled, NULL, &error) == TREPHINE_BAD_ARGUMENT);
  CHECK(trephine_scene_set_labels(labelled, labels, &error) == TREPHINE_OK);
  CHECK(trephine_scene_add_label(labelled, "dura", 256, &error) == -1 && strstr(error.text, "0 to 255"));
  CHECK(trephine_scene_add_label(labelled, "dura", 3, &error) == 0);
  CHECK(trephine_scene_set_labels(labelled, labels, &error) == TREPHINE_BAD_ARGUMENT);
  CHECK(trephine_scene_set_tool_radius(labelled, 7, &error) == TREPHINE_BAD_ARGUMENT);
  CHECK(trephine_scene_set_tool_radius(labelled, 2, &error) == TREPHINE_OK);
  CHECK(trephine_hand_create(labelled, 1000, &error) == NULL);
  CHECK(trephine_scene_prepare(labelled, &error) == TREPHINE_OK);
  CHECK(trephine_scene_set_sides(labelled, 0, TREPHINE_BACK, &error) == TREPHINE_BAD_ARGUMENT);
  CHECK(trephine_surface_get(labelled, 0, &error) == NULL && strstr(error.text, "without a radius"));
  trephine_hand* round_tip = trephine_hand_create(labelled, 1000, &error);
  CHECK(round_tip != NULL);
  for (int i = 0; i <= 1000; ++i) {
    const double at[3] = {0, 0, 23 - 0.005 * i};
    CHECK(trephine_hand_step(round_tip, at, &touch) == TREPHINE_OK);
  }
  CHECK(touch.has_contact && touch.shape == 0 && fabs(touch.proxy[2] - 20) < 0.4);
  trephine_hand_destroy(round_tip);
  trephine_scene_destroy(labelled);
  printf(failures ? "%d checks failed\n" : "all checks passed\n", failures);
  return failures != 0;
}
