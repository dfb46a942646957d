/* Touch a volume from C, or from any program that loads a library: game engines, haptics SDKs, scripts.
 *
 * Lengths mm, forces N, time s; world frame. Handles are opaque. Functions that can fail say so by their
 * result and, when `error` is not NULL, in words. Nothing throws, prints or exits.
 *
 * Threads: a scene is set up by one thread and then not changed while hands step. Each hand belongs to one
 * thread at a time; several hands may step on one scene at once. Materials and sides take
 * effect at once, but not with method "scene-sequential"; after another shape or method prepare again and
 * make the hands anew. trephine_hand_step and trephine_intersect_surface neither allocate nor lock nor wait.
 * The voxels are borrowed: they must stay where they are, unchanged, until the scene is destroyed. */
#ifndef TREPHINE_HAPTICS_C_API_H
#define TREPHINE_HAPTICS_C_API_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#define TREPHINE_ABI_VERSION 1

enum trephine_code {
  TREPHINE_OK = 0,
  TREPHINE_BAD_ARGUMENT = 1,
  TREPHINE_NO_MEMORY = 2,
  TREPHINE_NOT_PREPARED =
      3, /* shapes or method changed since trephine_scene_prepare, or hands are from before it */
  TREPHINE_REFUSED = 4,   /* a command that may not be done now; it changed nothing */
  TREPHINE_DIFFERENT = 5, /* a replay came to other bits than were recorded */
  TREPHINE_FAILED = 6     /* a file or disk */
};
enum trephine_side { TREPHINE_NONE = 0, TREPHINE_FRONT = 1, TREPHINE_BACK = 2, TREPHINE_BOTH = 3 };

/* What went wrong: what, where, found, expected and remedy in one text. */
typedef struct trephine_error {
  int code; /* trephine_code */
  char text[500];
} trephine_error;

typedef struct trephine_scene trephine_scene;
typedef struct trephine_hand trephine_hand;
typedef struct trephine_surface trephine_surface;

typedef struct trephine_material {
  double stiffness;       /* N/mm, above 0 */
  double damping;         /* N s/mm, 0 or more */
  double static_friction; /* coefficients, 0 <= dynamic <= static <= 2 */
  double dynamic_friction;
} trephine_material;

/* What one step did. */
typedef struct trephine_touch {
  double proxy[3];
  double normal[3]; /* unit, toward the proxy's side; 0 without contact */
  double force[3];  /* for the device: finite, limited, slew-limited */
  int has_contact;
  int shape; /* index of the touched shape, -1 without contact */
  int side;  /* TREPHINE_FRONT, TREPHINE_BACK or TREPHINE_NONE */
  uint32_t faults;
} trephine_touch;

/* TREPHINE_ABI_VERSION of the library that was loaded. */
uint32_t trephine_abi_version(void);

/* A scene over size[0] * size[1] * size[2] intensities, x fastest. `axes`: the world displacement (mm) of one
 * voxel step along x, then y, then z. NULL on failure. */
trephine_scene* trephine_scene_create(const int16_t* voxels, const int size[3], const double origin[3],
                                      const double axes[9], trephine_error* error);
/* Scenes and hands are destroyed in any order: a scene's memory stays until its last hand is destroyed too.
 * Its surfaces go with the scene, at once for the caller. */
void trephine_scene_destroy(trephine_scene* scene);
/* A shape: intensities low .. high, both included (high may be INFINITY). Its index, or -1. At most 8 shapes.
 */
int trephine_scene_add_window(trephine_scene* scene, const char* name, double low, double high,
                              trephine_error* error);
/* Labels of a segmentation, one a voxel as the voxels are; borrowed like these. Before any shape. */
int trephine_scene_set_labels(trephine_scene* scene, const uint8_t* labels, trephine_error* error);
/* A shape: the voxels with this label, made smooth. Its index among the windows, or -1. */
int trephine_scene_add_label(trephine_scene* scene, const char* name, int label, trephine_error* error);
/* The tip of all hands is a ball (mm, 0 to 6; 0: a point, as at first): positions are its middle's. Prepare
 * again: that makes a field of distances, in seconds where the volume is large. No surfaces are given
 * (trephine_surface_get) while the tip is a ball. */
int trephine_scene_set_tool_radius(trephine_scene* scene, double radius, trephine_error* error);
/* A shape from a graphics transfer function: piecewise linear opacity over rising intensities; what is more
 * opaque than `threshold` can be touched. That must be one stretch. Its index, or -1. */
int trephine_scene_add_opacity_ramp(trephine_scene* scene, const char* name, const double* intensities,
                                    const double* opacities, size_t count, double threshold,
                                    trephine_error* error);
/* A polygonal model: vertices (mm, x y z each) and triangles (three vertices each, counter-clockwise from
 * outside), copied. For method "scene". It counts as a shape after the windows, which come first: its index,
 * or -1. `mover`: 0 to 7 for a model that hands place each tick, -1 for one that stays. */
int trephine_scene_add_mesh(trephine_scene* scene, const char* name, const double* vertices,
                            size_t vertex_count, const uint32_t* triangles, size_t triangle_count, int mover,
                            trephine_error* error);
/* Pressed harder than `force` (N, 0: never) the shape lets the hand through, until that has gone `rearm` mm
 * from there. Before hands are made. */
int trephine_scene_set_pop_through(trephine_scene* scene, int shape, double force, double rearm,
                                   trephine_error* error);
int trephine_scene_set_material(trephine_scene* scene, int shape, const trephine_material* material,
                                trephine_error* error);
/* From which sides the shape or mesh holds: TREPHINE_FRONT (the default), TREPHINE_BACK or TREPHINE_BOTH, or
 * TREPHINE_NONE. */
int trephine_scene_set_sides(trephine_scene* scene, int shape, int sides, trephine_error* error);
/* "subvoxel" (the default), "implicit", ...: see trephine touch --help. */
int trephine_scene_set_method(trephine_scene* scene, const char* method, trephine_error* error);
/* Makes what steps need; shapes with two values near their surface (labels, thresholded data) are made smooth
 * for methods that touch smooth solids. Call after the last change, before hands and surfaces are made. */
int trephine_scene_prepare(trephine_scene* scene, trephine_error* error);

/* For hosts without a haptics engine: a hand with its proxy and force. `rate_hz`: 250 to 10000 steps a
 * second. */
trephine_hand* trephine_hand_create(const trephine_scene* scene, double rate_hz, trephine_error* error);
void trephine_hand_destroy(trephine_hand* hand);
/* One step at the device's position. A position that is no number gives no force and a latched fault. */
int trephine_hand_step(trephine_hand* hand, const double position[3], trephine_touch* touch);
/* May the shape hold this hand? From the next step on; all may at first. */
int trephine_hand_set_touchable(trephine_hand* hand, int shape, int is_touchable);
/* Of a shape's bits only those of voxels low .. high are there yet: elsewhere it lets the hand through, which
 * is an event. Both NULL: all are there, as at the start. */
int trephine_hand_set_ready(trephine_hand* hand, int shape, const int low[3], const int high[3]);
/* Where the model with this mover is from the next step on: mm, and a unit quaternion w x y z. A model that
 * moves onto the tool takes it along. */
int trephine_hand_set_mesh_placement(trephine_hand* hand, int mover, const double position[3],
                                     const double rotation[4]);
/* An effect beside the surfaces' forces, in words: "viscous damping=0.004", "line start=0,0,9 ahead=0,0,-1
 * resistance=2": see trephine touch --help. At most 8. */
int trephine_hand_add_effect(trephine_hand* hand, const char* words, trephine_error* error);
/* Forgets contact and faults. */
void trephine_hand_reset(trephine_hand* hand);

/* For haptics engines that ask custom shapes where a motion meets them: one surface a shape, to be passed as
 * `user`. The surfaces of one scene are asked by one thread; the first that is asked about a motion does the
 * work for all. Freed with the scene. NULL on failure. */
trephine_surface* trephine_surface_get(trephine_scene* scene, int shape, trephine_error* error);
/* Does the motion from `start` to `end` meet this surface first? 1: yes, with the point just before it, the
 * unit normal toward `start`, and the side that is met; 0: no, and nothing is written. `side` may be NULL. */
int trephine_intersect_surface(const double start[3], const double end[3], double point[3], double normal[3],
                               int* side, void* user);

#ifdef __cplusplus
}
#endif
#endif
