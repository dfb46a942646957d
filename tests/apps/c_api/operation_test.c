/* Operations in C: cut, undo, refused calls, recording, opening again, destruction in any order. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "apps/c_api/trephine.h"
#include "tests/scenes/c_check.h"

/* A block of bone on slices of 1.5 mm, with its lower third labelled. */
enum { X = 40, Y = 36, Z = 20, COUNT = X * Y * Z };
static int16_t voxels[COUNT], now[COUNT];
static uint8_t labels[COUNT];
/* The threshold 100 is the mean of bone and air, so that the surface is halfway between their voxels. */
static const char* k_scene =
    "structure=bone\nlow=100\nhigh=3000\nhand=burr\nparameters=diameter=4 removal_rate=60\nhand=\n"
    "\n# The forbidden structure is touchable, too.\nstructure=deep\nlabel=2\nforbidden=1\n";

static trephine_voxels make_block(void) {
  for (int z = 0; z < Z; ++z)
    for (int y = 0; y < Y; ++y)
      for (int x = 0; x < X; ++x) {
        const int is_solid = x > 1 && x < X - 2 && y > 1 && y < Y - 2 && z > 1 && z < Z - 5;
        voxels[(z * Y + y) * X + x] = is_solid ? 1200 : -1000;
        labels[(z * Y + y) * X + x] = (uint8_t)(is_solid ? (z < 7 ? 2 : 1) : 0);
      }
  const trephine_voxels block = {voxels, labels, {X, Y, Z}, {-10, -9, -15}, {0.5, 0, 0, 0, 0.5, 0, 0, 0, 1.5},
                                 1};
  return block;
}

/* Approximate world height of the block's top. */
static const double k_top = -15 + 1.5 * (Z - 5.5);

/* Steps both hands: the first drills to `depth` mm below the top, the second stays in the air. */
static int drill(trephine_operation* operation, double x, double depth, int ticks) {
  for (int i = 0; i < ticks; ++i) {
    const double z = k_top + 2 - (2 + depth) * i / ticks;
    const trephine_pose poses[2] = {{{x, 0, z}, {0, 0, 0, 0}, i > 10}, {{0, 0, 30}, {2, 0, 0, 0}, 0}};
    trephine_touch touches[2];
    trephine_error error;
    if (trephine_operation_step(operation, poses, touches, &error) != TREPHINE_OK)
      return printf("%s\n", error.text), 0;
    for (int a = 0; a < 3; ++a)
      if (!isfinite(touches[0].force[a]) || touches[1].has_contact) return 0;
  }
  const trephine_pose away[2] = {{{x, 0, 30}, {1, 0, 0, 0}, 0}, {{0, 0, 30}, {1, 0, 0, 0}, 0}};
  return trephine_operation_step(operation, away, NULL, NULL) == TREPHINE_OK;
}

static double measure(const trephine_operation* operation, const char* name) {
  trephine_measure one;
  for (size_t i = 0; i < trephine_operation_measure_count(operation); ++i)
    if (trephine_operation_measure(operation, i, &one) == TREPHINE_OK && strcmp(one.name, name) == 0)
      return one.value;
  return -1;
}

static int count_events(const trephine_operation* operation, const char* name) {
  int count = 0;
  trephine_event event;
  for (size_t i = 0; i < trephine_operation_event_count(operation); ++i)
    count += trephine_operation_event(operation, i, &event) == TREPHINE_OK && strcmp(event.name, name) == 0;
  return count;
}

/* Returns the removed volume by the intensities, mm3: removed bone changes from 1200 to -1000. */
static double removed_by_intensity(const trephine_operation* operation) {
  const int low[3] = {0, 0, 0}, high[3] = {X - 1, Y - 1, Z - 1};
  CHECK(trephine_operation_read(operation, low, high, now, NULL) == TREPHINE_OK);
  double sum = 0;
  for (int i = 0; i < COUNT; ++i) sum += (voxels[i] - now[i]) / 2200.0;
  return sum * 0.5 * 0.5 * 1.5;
}

static void check_refusals(const trephine_voxels* block) {
  trephine_error error;
  trephine_start start = {0};
  CHECK(trephine_operation_begin(NULL, &error) == NULL && error.code == TREPHINE_BAD_ARGUMENT);
  CHECK(trephine_operation_begin(&start, &error) == NULL);
  start.volumes = block, start.volume_count = 1;
  start.scene = "structure=bone\nlow=300\nhand=chisel\n";
  CHECK(trephine_operation_begin(&start, &error) == NULL && strstr(error.text, "chisel"));
  start.scene = "structure=bone\nlow=300\nhand=burr\nparameters=diameter=900\n";
  CHECK(trephine_operation_begin(&start, &error) == NULL && strstr(error.text, "diameter"));
  start.scene = "structure=bone\nlo=300\nhand=\n";
  CHECK(trephine_operation_begin(&start, &error) == NULL && strstr(error.text, "line 2"));
  start.scene = "structure=bone\nlow=3001\nhand=\n";
  CHECK(trephine_operation_begin(&start, &error) == NULL && strstr(error.text, "empty"));
  start.scene = "volume=3 4 5\nstructure=bone\nlow=300\nhand=\n";
  CHECK(trephine_operation_begin(&start, &error) == NULL && strstr(error.text, "3 x 4 x 5"));
  start.scene = "structure=bone\nlow=300\nhand=\n";
  trephine_voxels wrong = *block;
  start.volumes = &wrong;
  wrong.axes[0] = 1e-30;
  CHECK(trephine_operation_begin(&start, &error) == NULL && strstr(error.text, "0.001 to 1000"));
  wrong = *block;
  wrong.origin[2] = 1e300;
  CHECK(trephine_operation_begin(&start, &error) == NULL && strstr(error.text, "origin"));
  start.scene = "structure=bone\nlabel=1\nhand=\n";
  trephine_voxels bare = *block;
  bare.labels = NULL;
  start.volumes = &bare;
  CHECK(trephine_operation_begin(&start, &error) == NULL && strstr(error.text, "label"));
  CHECK(trephine_operation_open("/nowhere/at-all.session", NULL, 0, &error) == NULL && error.text[0]);
  CHECK(trephine_operation_step(NULL, NULL, NULL, &error) == TREPHINE_BAD_ARGUMENT);
  CHECK(trephine_operation_hash(NULL) == 0 && trephine_operation_tick_count(NULL) == 0);
  trephine_operation_destroy(NULL);
}

/* Images and the surface show the hole that was drilled at x = 0. */
static void check_images(trephine_operation* operation) {
  enum { PIXELS = 9 };
  const double middle[3] = {0, 0, k_top - 1}, right[3] = {1, 0, 0}, up[3] = {0, 1, 0}, none[3] = {0, 0, 0};
  int16_t values[PIXELS * PIXELS];
  trephine_error error;
  CHECK(trephine_operation_slice(operation, middle, right, up, 1.5, PIXELS, PIXELS, values, &error) ==
        TREPHINE_OK);
  CHECK(values[PIXELS * PIXELS / 2] < 0 && values[PIXELS * PIXELS / 2 - 4] > 1000);
  CHECK(trephine_operation_slice(operation, middle, right, none, 1.5, PIXELS, PIXELS, values, &error) ==
        TREPHINE_BAD_ARGUMENT);
  static uint8_t greys[64 * 64];
  CHECK(trephine_operation_xray(operation, middle, 0, 80, 0.5, 64, 64, greys, &error) == TREPHINE_OK);
  int low = 255, high = 0;
  for (int i = 0; i < 64 * 64; ++i)
    low = greys[i] < low ? greys[i] : low, high = greys[i] > high ? greys[i] : high;
  CHECK(high - low > 100);
  CHECK(trephine_operation_xray(operation, middle, 0, 80, -1, 64, 64, greys, &error) ==
        TREPHINE_BAD_ARGUMENT);
  trephine_model surface;
  CHECK(trephine_operation_surface(operation, 0, &surface, &error) == TREPHINE_OK);
  CHECK(surface.triangle_count > 1000);
  double lowest = 1e9; /* of the surface below the middle of the hole */
  for (size_t v = 0; v < surface.vertex_count; ++v) {
    const double* p = surface.vertices + 3 * v;
    if (p[0] * p[0] + p[1] * p[1] < 0.5 && p[2] > -8) lowest = fmin(lowest, p[2]);
  }
  CHECK(lowest < k_top - 2 && lowest > k_top - 6);
  CHECK(trephine_operation_surface(operation, 9, &surface, &error) == TREPHINE_BAD_ARGUMENT);
}

/* Opens a phantom by its name with one tool, and with wrong arguments. */
static void check_files(void) {
  trephine_error error;
  const trephine_tool burr = {.instrument = "burr", .parameters = "diameter=4"};
  trephine_scan scan = {.path = "head", .tools = &burr, .tool_count = 1};
  trephine_operation* operation = trephine_operation_open_scan(&scan, &error);
  if (!operation) printf("%s\n", error.text);
  CHECK(operation != NULL);
  const trephine_pose pose = {.position = {0, -20, 66}, .buttons = 1};
  trephine_touch touch;
  CHECK(trephine_operation_step(operation, &pose, &touch, &error) == TREPHINE_OK);
  CHECK(trephine_operation_verify(operation, &error) == TREPHINE_BAD_ARGUMENT);
  trephine_operation_destroy(operation);
  scan.path = "haed";
  CHECK(trephine_operation_open_scan(&scan, &error) == NULL && strstr(error.text, "haed"));
  scan.tool_count = 0;
  CHECK(trephine_operation_open_scan(&scan, &error) == NULL && strstr(error.text, "hands"));
  CHECK(trephine_operation_open_scan(NULL, &error) == NULL);
  CHECK(trephine_operation_reopen("missing.session", "head", &error) == NULL && error.text[0]);
  CHECK(trephine_load_module("missing.so", &error) == TREPHINE_BAD_ARGUMENT &&
        strstr(error.text, "missing.so"));
}

static trephine_operation* const no_operation = NULL;

static void keep_notice(const char* text, void* user) { *(const char**)user = text; }

/* A path moves the hand of an operation whose forces are limited to those of the device. */
static int check_devices(const char* path) {
  trephine_error error;
  CHECK(trephine_device_open(NULL, NULL, &error) == NULL && error.code == TREPHINE_BAD_ARGUMENT);
  CHECK(trephine_device_open("mouse", NULL, &error) == NULL && strstr(error.text, "window") != NULL);
  FILE* file = fopen(path, "w");
  if (!file) return 0;
  fprintf(file, "t,x,y,z\n0,0,-20,74\n0.5,0,-20,65\n1,0,-20,65\n");
  fclose(file);
  char name[5000];
  snprintf(name, sizeof name, "virtual:%s", path);
  const char* notice = NULL;
  trephine_device_options options = {0};
  options.notice = keep_notice, options.user = &notice;
  options.rotation[0] = 2;
  CHECK(trephine_device_open(name, &options, &error) == NULL); /* no unit quaternion */
  options.rotation[0] = 0;
  trephine_device* device = trephine_device_open(name, &options, &error);
  if (!device) return printf("%s\n", error.text), 0;
  CHECK(notice == NULL); /* a path needs no instructions */
  trephine_device_info info;
  CHECK(trephine_device_get_info(device, &info) == TREPHINE_OK && strcmp(info.name, "virtual") == 0);
  CHECK(info.max_force == 8);
  trephine_scan scan = {0};
  const trephine_tool tool = {0};
  const trephine_device* devices[1] = {device};
  scan.path = "head", scan.tools = &tool, scan.tool_count = 1;
  scan.devices = devices, scan.device_count = 1;
  trephine_operation* operation = trephine_operation_open_scan(&scan, &error);
  if (!operation) return printf("%s\n", error.text), 0;
  double most = 0;
  trephine_pose pose = {{0, 0, 0}, {0, 0, 0, 0}, 0};
  for (int tick = 0; tick < 800; ++tick) {
    trephine_touch touch;
    CHECK(trephine_device_read(device, 0.001 * tick, &pose) == TREPHINE_OK);
    CHECK(trephine_operation_step(operation, &pose, &touch, &error) == TREPHINE_OK);
    CHECK(trephine_device_write(device, &touch, NULL) == TREPHINE_OK);
    for (int a = 0; a < 3; ++a)
      if (fabs(touch.force[a]) > most) most = fabs(touch.force[a]);
  }
  CHECK(most > 0.3 && most <= 8);
  CHECK(pose.position[2] > 65.2); /* the hand yields to the force */
  CHECK(trephine_device_write(device, NULL, NULL) == TREPHINE_OK);
  CHECK(trephine_device_read(NULL, 0, &pose) == TREPHINE_BAD_ARGUMENT);
  trephine_operation_destroy(operation);
  trephine_device_close(device);
  trephine_device_close(NULL);
  remove(path);
  return 1;
}

int main(int argc, char** argv) {
  (void)argc;
  char session[4096], other[4096];
  snprintf(session, sizeof session, "%s.%ld.session", argv[0], (long)getpid());
  snprintf(other, sizeof other, "%s.%ld.other.session", argv[0], (long)getpid());
  CHECK(trephine_abi_version() == TREPHINE_ABI_VERSION);
  const trephine_voxels block = make_block();
  check_refusals(&block);
  check_files();
  CHECK(check_devices(other));

  trephine_error error;
  trephine_start start = {0};
  start.scene = k_scene, start.volumes = &block, start.volume_count = 1, start.record = session;
  trephine_operation* operation = trephine_operation_begin(&start, &error);
  if (!operation) return printf("%s\n", error.text), 1;
  CHECK(trephine_operation_hand_count(operation) == 2);
  CHECK(trephine_operation_begin(&start, &error) == NULL); /* the file already exists */

  /* The text of the scene starts another operation, which has the same text. */
  char scene[4096];
  CHECK(trephine_operation_scene(operation, NULL, 0) < sizeof scene);
  CHECK(trephine_operation_scene(operation, scene, sizeof scene) == strlen(scene));
  trephine_start again = start;
  again.scene = scene, again.record = other, again.is_embedding = 1;
  trephine_operation* twin = trephine_operation_begin(&again, &error);
  if (!twin) return printf("%s\n", error.text), 1;
  char same[4096];
  trephine_operation_scene(twin, same, sizeof same);
  CHECK(strcmp(scene, same) == 0);

  /* Cut: intensities and ledger agree, and the twin has the same bits. */
  int low[3], high[3];
  CHECK(!trephine_operation_changed(operation, low, high));
  CHECK(drill(operation, 0, 4, 1500) && drill(twin, 0, 4, 1500));
  const double removed = measure(operation, "removed");
  CHECK(removed > 20 && removed < 90);
  CHECK(fabs(removed_by_intensity(operation) - removed) < 0.005 * removed);
  CHECK(trephine_operation_hash(operation) == trephine_operation_hash(twin));
  CHECK(trephine_operation_changed(operation, low, high));
  for (int i = 0; i < COUNT; ++i) {
    const int at[3] = {i % X, i / X % Y, i / X / Y};
    int is_inside = 1;
    for (int a = 0; a < 3; ++a) is_inside &= at[a] >= low[a] && at[a] <= high[a];
    if (now[i] != voxels[i]) CHECK(is_inside);
  }
  CHECK(!trephine_operation_changed(operation, low, high));
  check_images(operation);

  /* A cut of the forbidden part is measured. */
  CHECK(measure(operation, "nearest to deep") > 0);
  CHECK(drill(operation, 6, 14, 4000));
  CHECK(measure(operation, "nearest to deep") < 0);
  CHECK(trephine_operation_hash(operation) != trephine_operation_hash(twin));

  /* Commands. */
  CHECK(trephine_operation_command(operation, 0, "undo", NULL, &error) == TREPHINE_OK);
  CHECK(fabs(measure(operation, "removed") - removed) < 1e-9 && measure(operation, "undos") == 1);
  CHECK(trephine_operation_changed(operation, low, high));
  CHECK(trephine_operation_command(operation, 0, "undo", "", &error) == TREPHINE_OK);
  CHECK(measure(operation, "removed") == 0 && removed_by_intensity(operation) == 0);
  CHECK(trephine_operation_command(operation, 0, "hold-body", "body=9", &error) == TREPHINE_REFUSED &&
        strstr(error.text, "9"));
  CHECK(trephine_operation_command(operation, 0, "redo", NULL, &error) == TREPHINE_OK);
  CHECK(trephine_operation_command(operation, 0, "no-such", NULL, &error) == TREPHINE_BAD_ARGUMENT &&
        strstr(error.text, "undo"));
  CHECK(trephine_operation_command(operation, 7, "undo", NULL, &error) == TREPHINE_BAD_ARGUMENT);
  CHECK(trephine_operation_command(operation, 0, "burr", "diameter=banana", &error) == TREPHINE_BAD_ARGUMENT);
  CHECK(trephine_operation_command(operation, 0, "adopt-job", "job=1", &error) == TREPHINE_BAD_ARGUMENT);
  CHECK(trephine_operation_command(operation, 0, "note", "text=\"from C\"", &error) == TREPHINE_OK);

  /* A pose that is not finite gives no force, a fault and an event; then the operation continues. */
  const trephine_pose broken[2] = {{{NAN, 0, 0}, {1, 0, 0, 0}, 1}, {{0, 0, 30}, {NAN, 0, 0, 0}, 0}};
  trephine_touch touches[2];
  CHECK(trephine_operation_step(operation, broken, touches, &error) == TREPHINE_OK);
  double torques[2][3] = {{1, 1, 1}, {1, 1, 1}};
  CHECK(trephine_operation_torques(operation, torques) == TREPHINE_OK && torques[0][0] == 0 &&
        torques[1][2] == 0);
  CHECK(trephine_operation_torques(operation, NULL) == TREPHINE_BAD_ARGUMENT);
  CHECK(touches[0].faults != 0 && touches[1].faults != 0 && touches[0].force[2] == 0 &&
        count_events(operation, "fault") > 0);

  /* The fault stays until it is reset. */
  const trephine_pose away[2] = {{{0, 0, 30}, {1, 0, 0, 0}, 0}, {{0, 0, 30}, {1, 0, 0, 0}, 0}};
  CHECK(trephine_operation_step(operation, away, touches, &error) == TREPHINE_OK && touches[0].faults != 0);
  CHECK(trephine_operation_reset(operation) == TREPHINE_OK);
  CHECK(trephine_operation_step(operation, away, touches, &error) == TREPHINE_OK && touches[0].faults == 0);
  CHECK(trephine_operation_tick(operation) == trephine_operation_tick_count(operation));

  const uint64_t hash = trephine_operation_hash(operation), ticks = trephine_operation_tick_count(operation);
  CHECK(ticks == 1501 + 4001 + 3);
  CHECK(trephine_operation_end(operation, &error) == TREPHINE_OK);
  CHECK(trephine_operation_end(operation, &error) == TREPHINE_BAD_ARGUMENT);
  CHECK(trephine_operation_command(operation, 0, "redo", NULL, &error) == TREPHINE_BAD_ARGUMENT);

  /* Opened again while the first operation still exists; replayed to its end, back, and verified. */
  trephine_operation* recorded = trephine_operation_open(session, &block, 1, &error);
  if (!recorded) return printf("%s\n", error.text), 1;
  trephine_operation_destroy(operation);
  CHECK(trephine_operation_tick_count(recorded) == ticks && trephine_operation_is_whole(recorded));
  CHECK(trephine_operation_tick(recorded) == 0);
  CHECK(trephine_operation_go_to(recorded, ticks, &error) == TREPHINE_OK);
  CHECK(trephine_operation_hash(recorded) == hash);
  CHECK(count_events(recorded, "fault") > 0);
  CHECK(trephine_operation_go_to(recorded, 1501, &error) == TREPHINE_OK);
  CHECK(fabs(measure(recorded, "removed") - removed) < 1e-9);
  CHECK(trephine_operation_step(recorded, broken, NULL, &error) == TREPHINE_BAD_ARGUMENT);
  CHECK(trephine_operation_tick(recorded) == 1501);
  CHECK(trephine_operation_verify(recorded, &error) == TREPHINE_OK || (printf("%s\n", error.text), 0));
  CHECK(trephine_operation_hash(recorded) == hash);

  /* A recording without an explicit end is whole, too; it contains its scan, and needs no other operation. */
  trephine_operation_destroy(twin);
  twin = trephine_operation_open(other, NULL, 0, &error);
  if (!twin) return printf("%s\n", error.text), 1;
  CHECK(trephine_operation_open(session, NULL, 0, &error) == NULL); /* this session requires its scan */
  trephine_operation_destroy(recorded);
  CHECK(trephine_operation_verify(twin, &error) == TREPHINE_OK);
  CHECK(fabs(measure(twin, "removed") - removed) < 1e-9);
  CHECK(trephine_operation_verify(no_operation, &error) == TREPHINE_BAD_ARGUMENT);
  /* Planted fault: a bit of the file is changed. The session opens up to the damage, which is reported. */
  FILE* file = fopen(session, "r+b");
  fseek(file, 0, SEEK_END);
  const long middle = ftell(file) / 2;
  fseek(file, middle, SEEK_SET);
  const int byte = fgetc(file);
  fseek(file, middle, SEEK_SET);
  fputc(byte ^ 1, file);
  fclose(file);
  recorded = trephine_operation_open(session, &block, 1, &error);
  CHECK(recorded != NULL && !trephine_operation_is_whole(recorded));
  CHECK(trephine_operation_verify(recorded, &error) == TREPHINE_FAILED && strstr(error.text, "damaged"));
  trephine_operation_destroy(recorded);
  /* Planted fault: other voxels are another scan. */
  voxels[COUNT / 2] = 999;
  CHECK(trephine_operation_open(session, &block, 1, &error) == NULL && strstr(error.text, "scan"));
  trephine_operation_destroy(twin);
  remove(session), remove(other);
  if (failures == 0) printf("all checks passed\n");
  return failures != 0;
}
