/* Drill from C: a block of bone, a burr that goes through, one undo. */
#include <apps/c_api/operation.h>
#include <stdio.h>

#define N 60

static int16_t voxels[N * N * N];

int main(void) {
  for (int i = 0; i < N * N * N; ++i) voxels[i] = i / (N * N) < 40 ? 1000 : -1000; /* a thick plate */
  const trephine_voxels plate = {voxels, NULL, {N, N, N}, {-15, -15, 0}, {0.5, 0, 0, 0, 0.5, 0, 0, 0, 0.5}, 1};
  const trephine_start start = {.scene = "structure=bone\nlow=300\nhand=burr\nparameters=diameter=4",
                                .volumes = &plate,
                                .volume_count = 1};
  trephine_error error;
  trephine_operation* operation = trephine_operation_begin(&start, &error);
  if (!operation) return printf("%s\n", error.text), 1;
  for (int i = 0; i <= 4000; ++i) {
    const trephine_pose pose = {.position = {0, 0, 24 - 0.002 * i}, .buttons = 1};
    trephine_touch touch;
    if (trephine_operation_step(operation, &pose, &touch, &error)) return printf("%s\n", error.text), 1;
    if (i % 500) continue;
    trephine_measure removed;
    trephine_operation_measure(operation, 0, &removed);
    printf("hand at %4.1f mm: %.2f N, %5.1f mm3 removed\n", pose.position[2], touch.force[2], removed.value);
  }
  trephine_operation_command(operation, 0, "undo", NULL, &error);
  trephine_operation_destroy(operation);
  return 0;
}
