/* C interface of trephine, for any program that loads a library: game engines, haptics SDKs, other languages.
 *
 *   Operations   a scan with hands and instruments: cuts, commands, undo, events, images, sessions
 *   Devices      haptic devices, 3-D mice and pedals that move the hands of an operation
 *   Touch        contact with voxels and models alone, for hosts with a servo loop of their own
 *
 * Lengths mm, forces N, time s; world frame (DICOM LPS). Handles are opaque. Functions that can fail report
 * it by their result and, if `error` is not NULL, as text. No function throws, prints or exits.
 *
 * The voxels are borrowed: keep them at their address and unchanged until their operation or scene is
 * destroyed. Models, texts and poses are copied. */
#ifndef TREPHINE_APPS_C_API_TREPHINE_H
#define TREPHINE_APPS_C_API_TREPHINE_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#define TREPHINE_ABI_VERSION 3

enum trephine_code {
  TREPHINE_OK = 0,
  TREPHINE_BAD_ARGUMENT = 1,
  TREPHINE_NO_MEMORY = 2,
  TREPHINE_NOT_PREPARED =
      3, /* shapes, tip or method changed, or the scene was prepared again after the hand was created */
  TREPHINE_REFUSED = 4,   /* a command that is not allowed now, or whose job had no effect */
  TREPHINE_DIFFERENT = 5, /* a replay whose result differs from the recording */
  TREPHINE_FAILED = 6     /* a file or disk error, or a session that cannot be verified */
};
enum trephine_side { TREPHINE_NONE = 0, TREPHINE_FRONT = 1, TREPHINE_BACK = 2, TREPHINE_BOTH = 3 };

/* Error: problem, location, found, expected and remedy in one text. */
typedef struct trephine_error {
  int code; /* trephine_code */
  char text[500];
} trephine_error;

/* Result of one step. World frame. */
typedef struct trephine_touch {
  double proxy[3];
  double normal[3]; /* unit, toward the proxy's side; 0 without contact */
  double force[3];  /* N, for the device: finite, limited, slew-limited */
  int has_contact;
  int shape;       /* index of the touched shape, -1 without contact */
  int side;        /* TREPHINE_FRONT, TREPHINE_BACK or TREPHINE_NONE */
  uint32_t faults; /* bits of the latched faults and of the faults of this step; 0: no fault */
} trephine_touch;

/* Returns TREPHINE_ABI_VERSION of the loaded library. */
uint32_t trephine_abi_version(void);

/* ======== Operations ========
 *
 * An operation belongs to one thread at a time; operations share no data, and may be destroyed in any order.
 * One step is one servo tick of each hand and the resulting edits; a step that cuts bone takes longer. Equal
 * poses and commands give equal bits on every machine. Destroying an operation first ends its recording. */

typedef struct trephine_operation trephine_operation;

/* A volume of size[0] * size[1] * size[2] voxels, x fastest. `origin`: centre of the first voxel, mm. `axes`:
 * displacement (mm) of one voxel step along x, then y, then z. `labels` may be NULL. */
typedef struct trephine_voxels {
  const int16_t* intensities;
  const uint8_t* labels;
  int size[3];
  double origin[3];
  double axes[9];
  int is_hounsfield; /* CT: removed matter becomes -1000 */
} trephine_voxels;

/* A polygonal model: vertices (mm, x y z each), triangles of three vertices, counter-clockwise from outside.
 */
typedef struct trephine_model {
  const double* vertices;
  size_t vertex_count;
  const uint32_t* triangles;
  size_t triangle_count;
} trephine_model;

/* Specification of an operation. Unused members are 0. */
typedef struct trephine_start {
  /* Lines of key=value: structures, hands, options. docs/file-formats.md, "A scene in text", lists all keys.
   * Empty lines and lines that begin with '#' are ignored; the keys "volume" and "model" may be omitted. A
   * minimal scene with a burr: "structure=bone\nlow=300\nhand=burr\nparameters=diameter=4" */
  const char* scene;
  const trephine_voxels* volumes; /* the first is the anatomy, and the only one that is cut */
  size_t volume_count;
  const trephine_model* models;
  size_t model_count;
  const char* record; /* a new file; NULL: no recording */
  int is_embedding;   /* nonzero: also writes the volumes to that file */
} trephine_start;

/* A hand of an operation on a file. `trephine modules` lists the instruments with their parameters. */
typedef struct trephine_tool {
  const char* instrument; /* "burr", ...; NULL: the hand only touches */
  const char* parameters; /* "diameter=4 removal_rate=30"; may be NULL */
  double tool_radius;     /* mm, radius of the ball that touches; 0: that of the instrument, or a point */
  const char* method;     /* contact method; NULL: "subvoxel" */
} trephine_tool;

typedef struct trephine_device trephine_device;

/* Specification of an operation on a file. Unused members are 0. */
typedef struct trephine_scan {
  const char* path;           /* DICOM folder, file, case; or a phantom: "head", "spine" */
  const trephine_tool* tools; /* one per hand */
  size_t tool_count;
  const char* window; /* solid values "LO:HI"; NULL: structures of the case, or bone */
  const char* label;  /* a label that is solid, instead of a window; NULL: no label */
  int uses_plan;      /* nonzero: also use the structures and screws of a phantom */
  double rate_hz;     /* ticks per second; 0: 1000 */
  const char* record; /* a new file; NULL: no recording */
  int is_embedding;   /* nonzero: also writes the scan to that file */
  /* Devices that render the forces: force, torque and the stiffness of the structures are
   * reduced to their limits. */
  const trephine_device* const* devices;
  size_t device_count;
} trephine_scan;

typedef struct trephine_pose {
  double position[3];
  double rotation[4]; /* unit quaternion w x y z; all 0: identity */
  uint32_t buttons;   /* bit 0: the instrument is active */
} trephine_pose;

typedef struct trephine_event {
  uint64_t tick;
  int hand;
  double position[3]; /* mm */
  char name[64];
  char words[400]; /* parameters, truncated if longer: "structure=dura deepest=0.2" */
} trephine_event;

typedef struct trephine_measure {
  char name[128]; /* "removed", "changes", "nearest to dura", ... */
  char unit[16];  /* "mm3"; empty: no unit */
  double value;
} trephine_measure;

/* A detached body, or an implant. The surface of a detached body is in the world frame, as the body lay when
 * it was detached; the surface of an implant is in the implant's own frame. The arrays of `surface` remain
 * valid until the next step, command, go_to or verify of this operation. */
typedef struct trephine_body {
  uint32_t id; /* number in commands: "hold-body" with "body=3" */
  int holder;  /* the hand that holds it; -1: not held */
  double mm3;
  double position[3]; /* current pose of the frame of `surface`: mm, and unit quaternion w x y z */
  double rotation[4];
  trephine_model surface;
} trephine_body;

/* Creates an operation. Returns NULL on failure. */
trephine_operation* trephine_operation_begin(const trephine_start* start, trephine_error* error);
/* Creates an operation on a scan, a case or a phantom. Returns NULL on failure. */
trephine_operation* trephine_operation_open_scan(const trephine_scan* scan, trephine_error* error);
/* Opens a recorded operation at its beginning, read-only. `volumes`: the volumes that the file does not
 * contain, the anatomy first; phantoms need none. Returns NULL on failure. */
trephine_operation* trephine_operation_open(const char* session, const trephine_voxels* volumes,
                                            size_t volume_count, trephine_error* error);
/* Opens a recorded operation with the scan of this path. Returns NULL on failure. */
trephine_operation* trephine_operation_reopen(const char* session, const char* scan, trephine_error* error);
/* Loads a module of a shared library, for operations that are created afterwards. */
int trephine_load_module(const char* path, trephine_error* error);
/* `operation` may be NULL. */
void trephine_operation_destroy(trephine_operation* operation);

/* ---- new operations: trephine_operation_begin and trephine_operation_open_scan ---- */
/* Executes one tick with one pose per hand, in the order of the hands. `touches`: results per hand, or NULL.
 * A non-finite position gives zero force and a latched fault. */
int trephine_operation_step(trephine_operation* operation, const trephine_pose* poses,
                            trephine_touch* touches, trephine_error* error);
/* Writes the torque of each hand in the last step, for the device, in the order of the hands: N mm, about the
 * position of its pose; finite, limited and slew-limited. 0 before the first step, and for tools of one point
 * or ball without an effect that turns the hand. */
int trephine_operation_torques(const trephine_operation* operation, double (*torques)[3]);
/* Executes a command by name with parameters as key=value: "undo", "redo", "note" with "text=\"two words\"",
 * "burr" with "diameter=3", "free-pieces", "hold-body" with "body=1", ...: `trephine modules` lists them.
 * Longer work (a job) is finished before the function returns. Returns TREPHINE_REFUSED, without a change, if
 * the command is not allowed now; undo and redo with an empty history succeed without a change. A job whose
 * result cannot be used (no body was detached) also returns TREPHINE_REFUSED, and emits "job-discarded". */
int trephine_operation_command(trephine_operation* operation, int hand, const char* command,
                               const char* words, trephine_error* error);
/* Clears faults, contact and force with the next step. After a non-finite pose the force is 0 until that
 * step.
 */
int trephine_operation_reset(trephine_operation* operation);
/* Ends the operation, and finishes its recording if there is one. Returns TREPHINE_FAILED with the first
 * error of the recording. Afterwards only queries are possible. */
int trephine_operation_end(trephine_operation* operation, trephine_error* error);

/* ---- recorded operations: trephine_operation_open and trephine_operation_reopen ---- */
/* Seeks forward or back to the state after `tick` ticks; 0: the beginning. The last tick and beyond: the end,
 * including the commands after the last tick. */
int trephine_operation_go_to(trephine_operation* operation, uint64_t tick, trephine_error* error);
/* Replays the whole session from its beginning. Returns TREPHINE_DIFFERENT, with location and values, if
 * forces or voxels differ from the recording; TREPHINE_FAILED if they cannot be compared: the file is damaged
 * or unreadable, or was recorded by a program with another arithmetic. */
int trephine_operation_verify(trephine_operation* operation, trephine_error* error);

/* Returns 1 if the session file was closed properly; 0 if the end of the file was lost and only the part
 * before it is available. */
int trephine_operation_is_whole(const trephine_operation* operation);

/* ---- all operations ---- */
/* Number of ticks executed so far. */
uint64_t trephine_operation_tick(const trephine_operation* operation);
/* Number of ticks in the session file of a recorded operation. For a new operation it is equal to
 * trephine_operation_tick. */
uint64_t trephine_operation_tick_count(const trephine_operation* operation);
size_t trephine_operation_hand_count(const trephine_operation* operation);
/* Writes the scene in the format of trephine_start::scene, at most `capacity` bytes including the terminating
 * 0. Returns the length without it. */
size_t trephine_operation_scene(const trephine_operation* operation, char* text, size_t capacity);
/* Returns the hash of the whole state: equal states have equal hashes. The cost grows with removed matter. */
uint64_t trephine_operation_hash(trephine_operation* operation);
/* Number of events; undo removes no events. */
size_t trephine_operation_event_count(const trephine_operation* operation);
/* Events (oldest first), measures and bodies by index. The functions return TREPHINE_BAD_ARGUMENT for an
 * index beyond the last. */
int trephine_operation_event(const trephine_operation* operation, size_t index, trephine_event* event);
size_t trephine_operation_measure_count(const trephine_operation* operation);
int trephine_operation_measure(const trephine_operation* operation, size_t index, trephine_measure* measure);
size_t trephine_operation_body_count(trephine_operation* operation);
int trephine_operation_body(trephine_operation* operation, size_t index, trephine_body* body);
/* Returns 1 and the box low .. high (inclusive) of the anatomy's voxels that may have changed since the last
 * call; 0 if no voxels changed. */
int trephine_operation_changed(trephine_operation* operation, int low[3], int high[3]);
/* Reads the current intensities of the box low .. high (inclusive), x fastest. A voxel approaches air (-1000
 * HU; the lowest value of other scans) in proportion to its removed share. */
int trephine_operation_read(const trephine_operation* operation, const int low[3], const int high[3],
                            int16_t* intensities, trephine_error* error);
/* Surface of the structure with this index, with its cuts. The arrays remain valid until the next call of
 * this function or the destruction of the operation. */
int trephine_operation_surface(trephine_operation* operation, size_t structure, trephine_model* surface,
                               trephine_error* error);
/* Intensities in a plane of columns * rows pixels of `pixel` mm, with the cuts, row by row from the upper
 * left; -32768 outside the scan. `right` and `up`: orthogonal unit vectors. */
int trephine_operation_slice(const trephine_operation* operation, const double middle[3],
                             const double right[3], const double up[3], double pixel, int columns, int rows,
                             int16_t* intensities, trephine_error* error);
/* X-ray of a CT, with bodies and models, in grey values. Angles of the C-arm in degrees, as in DICOM: primary
 * positive toward the left, secondary toward the head. `pixel`: mm, of the detector. */
int trephine_operation_xray(trephine_operation* operation, const double isocentre[3], double primary,
                            double secondary, double pixel, int columns, int rows, uint8_t* greys,
                            trephine_error* error);

/* ======== Devices ========
 *
 * A device moves a hand of an operation: read a pose, step the operation, write the touch, about once per
 * millisecond. Reading and writing neither allocate nor wait. A device belongs to one thread at a time. */

typedef struct trephine_device_options {
  const char* pedal; /* "pedal", "pedal:1": its buttons are added to the poses; NULL: no pedal */
  double scale;      /* motion of the tool per motion of the device, 0.1 to 10; 0: 1 */
  double start[3];   /* mm, position of the tool when the device is opened */
  /* Rotation from the device (x to the right, y up, z toward the user) to the world, unit quaternion w x y z;
   * all 0: identity. */
  double rotation[4];
  void (*notice)(const char* text, void* user); /* receives instructions for the user; may be NULL */
  void* user;
} trephine_device_options;

/* Capabilities of an open device. */
typedef struct trephine_device_info {
  char name[64];
  int degrees_of_freedom;
  double max_force;        /* N; 0: no force output */
  double max_torque;       /* N mm; 0: no torque output, or unknown */
  double max_stiffness;    /* N/mm; 0: unknown */
  double workspace_radius; /* mm */
} trephine_device_info;

/* Opens a device by its name: "falcon", "touch", "spacemouse:1", "playback:PATH.csv" (docs/devices.md). Takes
 * up to some seconds, longer while the user homes the device. `options` may be NULL. Returns NULL on failure.
 */
trephine_device* trephine_device_open(const char* name, const trephine_device_options* options,
                                      trephine_error* error);
/* Switches the force off, and closes the device. `device` may be NULL. */
void trephine_device_close(trephine_device* device);
int trephine_device_get_info(const trephine_device* device, trephine_device_info* info);
/* Reads the pose at time t (s) of the program's loop. Returns TREPHINE_FAILED, and leaves `pose` as it is, if
 * the device does not respond. */
int trephine_device_read(trephine_device* device, double t, trephine_pose* pose);
/* Renders the force of a touch, and a torque (N mm; may be NULL), within the limits of the device. `touch`
 * NULL: no force. Hardware switches its force off 50 ms after the last call. */
int trephine_device_write(trephine_device* device, const trephine_touch* touch, const double torque[3]);

/* ======== Touch ========
 *
 * Threads: set up a scene on one thread and do not change it while hands step. Each hand belongs to one
 * thread at a time; several hands may step on one scene at once. Changes of materials and sides take effect
 * at once, except with method "scene-sequential". After a change of shapes or method, prepare the scene and
 * create the hands again. trephine_hand_step and trephine_intersect_surface do not allocate, lock or wait. */

typedef struct trephine_scene trephine_scene;
typedef struct trephine_hand trephine_hand;
typedef struct trephine_surface trephine_surface;

typedef struct trephine_material {
  double stiffness;       /* N/mm, above 0 */
  double damping;         /* N s/mm, 0 or more */
  double static_friction; /* coefficients, 0 <= dynamic <= static <= 2 */
  double dynamic_friction;
} trephine_material;

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
/* Adds a shape: the voxels with this label. Returns its index among the shapes, or -1. */
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
 * from outside), copied. Requires a method that touches models, such as "scene" (trephine_scene_set_method).
 * Add all windows and labels before the first model. Returns the index of the model among the shapes, or -1.
 * `mover`: 0 to 7 for a model that trephine_hand_set_mesh_placement moves, -1 for a fixed model. */
int trephine_scene_add_mesh(trephine_scene* scene, const char* name, const double* vertices,
                            size_t vertex_count, const uint32_t* triangles, size_t triangle_count, int mover,
                            trephine_error* error);
/* Lets a hand through the shape when the hand presses harder than `force` (N; 0: never), until the hand
 * has moved `rearm` mm from the position where it pressed. Call before hands are created. */
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
/* Sets whether the shape may block this hand, from the next step on. Initially all shapes may block it. */
int trephine_hand_set_touchable(trephine_hand* hand, int shape, int is_touchable);
/* Limits the occupancy of a shape to the voxels low .. high, while the other voxels are not available.
 * Outside this box, and within a few voxels of its border, the shape lets the hand through. Both NULL (the
 * initial state): all voxels are available. At most 8 shapes of a hand can have a box; a further shape lets
 * the hand through everywhere. */
int trephine_hand_set_ready(trephine_hand* hand, int shape, const int low[3], const int high[3]);
/* Places the model with this mover from the next step on: position in mm, and a unit quaternion w x y z. A
 * model that moves onto the tool pushes it along. */
int trephine_hand_set_mesh_placement(trephine_hand* hand, int mover, const double position[3],
                                     const double rotation[4]);
/* Adds an effect to the forces of the surfaces, given as text: "viscous damping=0.004", "line start=0,0,9
 * ahead=0,0,-1 resistance=2": see trephine touch --help. At most 8. */
int trephine_hand_add_effect(trephine_hand* hand, const char* words, trephine_error* error);
/* Clears contact, force and faults. */
void trephine_hand_reset(trephine_hand* hand);

/* For haptics engines that query custom shapes for the first intersection of a motion: returns one surface
 * per shape, to be passed as `user`. One thread may query the surfaces of a scene; the first query for a
 * motion computes the result for all of them. Freed with the scene. NULL on failure. */
trephine_surface* trephine_surface_get(trephine_scene* scene, int shape, trephine_error* error);
/* Tests whether the surface `user` is the first that the motion from `start` to `end` meets. Returns 1 if so,
 * and sets the point just before the surface, the unit normal toward `start`, and the side. Otherwise returns
 * 0 and writes nothing. `point`, `normal` and `side` may be NULL. */
int trephine_intersect_surface(const double start[3], const double end[3], double point[3], double normal[3],
                               int* side, void* user);

#ifdef __cplusplus
}
#endif
#endif
