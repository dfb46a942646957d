/* Drills from C: a burr is pressed into a thick plate of bone; the operation is recorded, undone and opened
 * again. With trephine installed in PREFIX: cc drill.c -IPREFIX/include -LPREFIX/lib/... -ltrephine-c_api */
#include <stdio.h>
#include <trephine/trephine.h>

#define N 60

static int16_t voxels[N * N * N];
static const char* const k_file = "example-drill.session";

static int fail(const trephine_error* error) {
  printf("%s\n", error->text);
  remove(k_file);
  return 1;
}

int main(void) {
  for (int i = 0; i < N * N * N; ++i) voxels[i] = i / (N * N) < 40 ? 1000 : -1000;
  const trephine_voxels plate = {voxels, NULL, {N, N, N}, {-15, -15, 0}, {0.5, 0, 0, 0, 0.5, 0, 0, 0, 0.5},
                                 1};
  const trephine_start start = {
      .scene = "structure=bone\nlow=300\nhand=burr\nparameters=diameter=4 removal_rate=8",
      .volumes = &plate,
      .volume_count = 1,
      .record = k_file};
  remove(k_file); /* a recording never overwrites a file */
  trephine_error error;
  trephine_operation* operation = trephine_operation_begin(&start, &error);
  if (!operation) return fail(&error);
  trephine_measure removed;
  /* Pushes faster than the burr drills, which renders a force; then lifts it. */
  for (int i = 0; i <= 4000; ++i) {
    const trephine_pose pose = {.position = {0, 0, i < 4000 ? 24 - 0.002 * i : 30}, .buttons = i < 4000};
    trephine_touch touch;
    if (trephine_operation_step(operation, &pose, &touch, &error)) return fail(&error);
    trephine_operation_measure(operation, 0, &removed); /* the first measure is "removed" */
    if (i % 500 == 0)
      printf("hand at %4.1f mm: %.2f N, %5.1f mm3 removed\n", pose.position[2], touch.force[2],
             removed.value);
  }
  if (trephine_operation_command(operation, 0, "undo", NULL, &error)) return fail(&error);
  trephine_operation_measure(operation, 0, &removed);
  printf("after undo: %.1f mm3 removed\n", removed.value);
  if (trephine_operation_end(operation, &error)) return fail(&error);
  trephine_operation_destroy(operation);

  operation = trephine_operation_open(k_file, &plate, 1, &error);
  if (!operation || trephine_operation_verify(operation, &error)) return fail(&error);
  printf("played again: %d ticks, the same bits\n", (int)trephine_operation_tick(operation));
  trephine_operation_destroy(operation);
  remove(k_file);
  return 0;
}
