/* Touches a ball of bone from above, in C. With trephine installed in PREFIX: cc touch.c
 * -IPREFIX/include -LPREFIX/lib/... -ltrephine-c_api */
#include <stdio.h>
#include <trephine/trephine.h>

#define N 80

static int16_t voxels[N * N * N];

int main(void) {
  for (int i = 0; i < N * N * N; ++i) {
    const int x = i % N - N / 2, y = i / N % N - N / 2, z = i / N / N - N / 2;
    voxels[i] = x * x + y * y + z * z < 30 * 30 ? 1000 : -1000;
  }
  const int size[3] = {N, N, N};
  const double origin[3] = {-N / 2, -N / 2, -N / 2}, axes[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
  trephine_error error;
  trephine_scene* scene = trephine_scene_create(voxels, size, origin, axes, &error);
  trephine_hand* hand = NULL;
  if (scene && trephine_scene_add_window(scene, "bone", 300, 3000, &error) == 0 &&
      trephine_scene_prepare(scene, &error) == TREPHINE_OK)
    hand = trephine_hand_create(scene, 1000, &error);
  if (!hand) return printf("%s\n", error.text), 1;
  for (int i = 0; i <= 5000; ++i) {
    const double at[3] = {0, 0, 50 - 0.005 * i};
    trephine_touch touch;
    trephine_hand_step(hand, at, &touch);
    if (i % 500 == 0) printf("hand at %5.1f mm, %.2f N\n", at[2], touch.force[2]);
  }
  trephine_hand_destroy(hand);
  trephine_scene_destroy(scene);
  return 0;
}
