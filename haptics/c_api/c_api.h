/* C interface of haptic contact with volumes, for any program that loads a library: game engines, haptics
 * SDKs, scripts.
 *
 * Lengths mm, forces N, time s; world frame. Handles are opaque. Functions that can fail report it by their
 * result and, if `error` is not NULL, as text. No function throws, prints or exits.
 *
 * Threads: set up a scene on one thread and do not change it while hands step. Each hand belongs to one
 * thread at a time; several hands may step on one scene at once. Changes of materials and sides take effect
 * at once, except with method "scene-sequential". After a change of shapes or method, prepare the scene and
 * create the hands again. trephine_hand_step and trephine_intersect_surface do not allocate, lock or wait.
 *
 * The voxels are borrowed: keep them at their address and unchanged until the scene is destroyed. */
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
      3, /* shapes or method changed since trephine_scene_prepare, or the hand is older than it */
  TREPHINE_REFUSED = 4,   /* a command that is not allowed now; the state is unchanged */
  TREPHINE_DIFFERENT = 5, /* a replay whose result differs from the recording */
  TREPHINE_FAILED = 6     /* a file or disk error */
};
enum trephine_side { TREPHINE_NONE = 0, TREPHINE_FRONT = 1, TREPHINE_BACK = 2, TREPHINE_BOTH = 3 };

/* Error: problem, location, found, expected and remedy in one text. */
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

/* Result of one step. World frame. */
typedef struct trephine_touch {
  double proxy[3];
  double normal[3]; /* unit, toward the proxy's side; 0 without contact */
  double force[3];  /* N, for the device: finite, limited, slew-limited */
  int has_contact;
  int shape; /* index of the touched shape, -1 without contact */
  int side;  /* TREPHINE_FRONT, TREPHINE_BACK or TREPHINE_NONE */
  uint32_t faults;
} trephine_touch;

/* Returns TREPHINE_ABI_VERSION of the loaded library. */
uint32_t trephine_abi_version(void);

/* Creates a scene over size[0] * size[1] * size[2] intensities, x fastest. `origin`: world position (mm) of
 * the first voxel's centre. `axes`: world displacement (mm) of one voxel step along x, then y, then z. NULL
 * on failure. */
trephine_scene* trephine_scene_create(const int16_t* voxels, const int size[3], const double origin[3],
                                      const double axes[9], trephine_error* error);
/* Scenes and hands may be destroyed in any order: a scene's memory is freed with its last hand. Its surfaces
 * must not be used after this call. */
void trephine_scene_destroy(trephine_scene* scene);
/* Adds a shape: intensities low .. high, both included (high may be INFINITY). Returns its index, or -1. At
 * most 8 shapes. */
int trephine_scene_add_window(trephine_scene* scene, const char* name, double low, double high,
                              trephine_error* error);
/* Sets the labels of a segmentation, one per voxel in the order of the voxels; borrowed like them. Call
 * before any shape is added. */
int trephine_scene_set_labels(trephine_scene* scene, const uint8_t* labels, trephine_error* error);
/* Adds a shape: the voxels with this label, smoothed. Returns its index among the windows, or -1. */
int trephine_scene_add_label(trephine_scene* scene, const char* name, int label, trephine_error* error);
/* Makes the tip of all hands a ball (radius in mm, 0 to 6; 0, the default, is a point): positions are those
 * of its centre. Prepare again afterwards: that builds a distance field, which takes seconds for large
 * volumes. trephine_surface_get fails while the tip is a ball. */
int trephine_scene_set_tool_radius(trephine_scene* scene, double radius, trephine_error* error);
/* Adds a shape from a graphics transfer function: piecewise linear opacity over increasing intensities.
 * Intensities with an opacity above `threshold` are touchable; they must form one interval. Returns its
 * index, or -1. */
int trephine_scene_add_opacity_ramp(trephine_scene* scene, const char* name, const double* intensities,
                                    const double* opacities, size_t count, double threshold,
                                    trephine_error* error);
/* Adds a polygonal model: vertices (mm, x y z each) and triangles (three vertices each, counter-clockwise
 * from outside), copied. For method "scene". Returns its index among the shapes, or -1; windows come before
 * meshes. `mover`: 0 to 7 for a model that hands place every tick, -1 for a fixed one. */
int trephine_scene_add_mesh(trephine_scene* scene, const char* name, const double* vertices,
                            size_t vertex_count, const uint32_t* triangles, size_t triangle_count, int mover,
                            trephine_error* error);
/* Lets a hand through the shape when it presses harder than `force` (N; 0: never), until the hand has moved
 * `rearm` mm from there. Call before hands are created. */
int trephine_scene_set_pop_through(trephine_scene* scene, int shape, double force, double rearm,
                                   trephine_error* error);
int trephine_scene_set_material(trephine_scene* scene, int shape, const trephine_material* material,
                                trephine_error* error);
/* Sets the sides from which the shape or mesh blocks: TREPHINE_FRONT (the default), TREPHINE_BACK,
 * TREPHINE_BOTH or TREPHINE_NONE. */
int trephine_scene_set_sides(trephine_scene* scene, int shape, int sides, trephine_error* error);
/* Sets the contact method: "subvoxel" (the default), "implicit", ...: see trephine touch --help. */
int trephine_scene_set_method(trephine_scene* scene, const char* method, trephine_error* error);
/* Builds the data that steps need. Shapes with two values near their surface (labels, thresholded data) are
 * smoothed for methods that touch smooth solids. Call after the last change, before hands and surfaces are
 * created. */
int trephine_scene_prepare(trephine_scene* scene, trephine_error* error);

/* Creates a hand with its proxy and force, for hosts without a haptics engine. `rate_hz`: 250 to 10000 steps
 * per second. */
trephine_hand* trephine_hand_create(const trephine_scene* scene, double rate_hz, trephine_error* error);
void trephine_hand_destroy(trephine_hand* hand);
/* Runs one step at the device's position. A non-finite position gives no force and latches a fault. */
int trephine_hand_step(trephine_hand* hand, const double position[3], trephine_touch* touch);
/* Sets whether the shape may block this hand, from the next step on. All shapes may at first. */
int trephine_hand_set_touchable(trephine_hand* hand, int shape, int is_touchable);
/* Limits the occupancy of a shape to the voxels low .. high, because the rest is not available yet: elsewhere
 * the shape lets the hand through, which is an event. Both NULL (the initial state): all is available. */
int trephine_hand_set_ready(trephine_hand* hand, int shape, const int low[3], const int high[3]);
/* Places the model with this mover from the next step on: position in mm, and a unit quaternion w x y z. A
 * model that moves onto the tool pushes it along. */
int trephine_hand_set_mesh_placement(trephine_hand* hand, int mover, const double position[3],
                                     const double rotation[4]);
/* Adds an effect to the forces of the surfaces, given as text: "viscous damping=0.004", "line start=0,0,9
 * ahead=0,0,-1 resistance=2": see trephine touch --help. At most 8. */
int trephine_hand_add_effect(trephine_hand* hand, const char* words, trephine_error* error);
/* Clears contact and faults. */
void trephine_hand_reset(trephine_hand* hand);

/* For haptics engines that query custom shapes for the first intersection of a motion: returns one surface
 * per shape, to be passed as `user`. One thread may query the surfaces of a scene; the first query for a
 * motion computes the result for all of them. Freed with the scene. NULL on failure. */
trephine_surface* trephine_surface_get(trephine_scene* scene, int shape, trephine_error* error);
/* Tests whether this surface is the first that the motion from `start` to `end` meets. 1: yes; sets the point
 * just before it, the unit normal toward `start`, and the side. 0: no; nothing is written. `side` may be
 * NULL. */
int trephine_intersect_surface(const double start[3], const double end[3], double point[3], double normal[3],
                               int* side, void* user);

#ifdef __cplusplus
}
#endif
#endif
