/* C interface of operations, for any program that loads a library: a scene from text, hands with
 * instruments, cuts, commands, undo, events, and sessions that are recorded and reopened.
 *
 * Lengths mm, forces N, time s; world frame. Errors as in haptics/c_api/c_api.h. No function throws, prints
 * or exits.
 *
 * Threads: an operation belongs to one thread at a time; operations share no data. One step is one servo tick
 * of each hand and the resulting edits, and takes longer while bone is cut. Equal poses and commands give
 * equal bits on every machine.
 *
 * Operations may be destroyed in any order; they need no other object of this interface. The voxels are
 * borrowed: keep them at their address and unchanged until the operation is destroyed. Models, texts and
 * poses are copied. Destroying an operation first ends its recording. */
#ifndef TREPHINE_APPS_C_API_OPERATION_H
#define TREPHINE_APPS_C_API_OPERATION_H

#include <haptics/c_api/c_api.h>

#ifdef __cplusplus
extern "C" {
#endif

#define TREPHINE_OPERATION_ABI_VERSION 1

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
   * Empty lines and lines that begin with '#' are ignored; "volume" and "model" may be omitted. A minimal
   * scene with a burr: "structure=bone\nlow=300\nhand=burr\nparameters=diameter=4" */
  const char* scene;
  const trephine_voxels* volumes; /* the first is the anatomy, and the only one that is cut */
  size_t volume_count;
  const trephine_model* models;
  size_t model_count;
  const char* record; /* a new file; NULL: no recording */
  int is_embedding;   /* nonzero: also writes the volumes to that file */
} trephine_start;

typedef struct trephine_pose {
  double position[3];
  double rotation[4]; /* unit quaternion w x y z; all 0: identity */
  uint32_t buttons;   /* bit 0: the instrument is active */
} trephine_pose;

typedef struct trephine_event {
  uint64_t tick;
  int hand;
  double place[3]; /* position, mm */
  char name[64];
  char words[400]; /* parameters, truncated if longer: "depth=0.2 structure=dura" */
} trephine_event;

typedef struct trephine_measure {
  char name[128]; /* "removed", "strokes", "nearest to dura", ... */
  char unit[16];  /* "mm3"; empty: no unit */
  double value;
} trephine_measure;

/* A detached body. `surface` is in the frame in which the body was detached; its arrays remain valid until
 * the next step, command or go_to of this operation. */
typedef struct trephine_body {
  uint32_t id; /* number in commands: "hold-body" with "body=3" */
  int holder;  /* the hand that holds it; -1: not held */
  double mm3;
  double position[3]; /* current pose of that frame */
  double rotation[4];
  trephine_model surface;
} trephine_body;

/* Returns TREPHINE_OPERATION_ABI_VERSION of the loaded library. */
uint32_t trephine_operation_abi_version(void);

/* Creates an operation. Returns NULL on failure. */
trephine_operation* trephine_operation_begin(const trephine_start* start, trephine_error* error);
/* Opens a recorded operation at its beginning, read-only. `volumes`: the volumes that the file does not
 * contain, the anatomy first. Returns NULL on failure. */
trephine_operation* trephine_operation_open(const char* session, const trephine_voxels* volumes,
                                            size_t volume_count, trephine_error* error);
/* `operation` may be NULL. */
void trephine_operation_destroy(trephine_operation* operation);

/* ---- operations of trephine_operation_begin ---- */
/* Executes one tick with one pose per hand, in the order of the hands. `touches`: results per hand, or NULL.
 * A non-finite position gives zero force and a latched fault. */
int trephine_operation_step(trephine_operation* operation, const trephine_pose* poses,
                            trephine_touch* touches, trephine_error* error);
/* Executes a command by name with parameters as key=value: "undo", "redo", "note" with "text=\"two words\"",
 * "burr" with "diameter=3", "free-pieces", "hold-body" with "body=1", ...: `trephine modules` lists them.
 * Longer work (a job) is finished before this returns. Returns TREPHINE_REFUSED, without a change, if the
 * command is not allowed now; undo and redo with an empty history succeed without a change. A job whose
 * result cannot be used (no body was detached) raises an event "job-discarded". */
int trephine_operation_command(trephine_operation* operation, int hand, const char* command,
                               const char* words, trephine_error* error);
/* Clears faults, contact and force with the next step. After a non-finite pose the force is 0 until then. */
int trephine_operation_reset(trephine_operation* operation);
/* Ends the operation, and finishes its recording if there is one. Returns TREPHINE_FAILED with the first
 * error of the recording. Afterwards only queries are possible. */
int trephine_operation_end(trephine_operation* operation, trephine_error* error);

/* ---- operations of trephine_operation_open ---- */
/* Seeks forward or back to the state after `tick` ticks; 0: the beginning. The last tick and beyond: the end,
 * including the commands after the last tick. */
int trephine_operation_go_to(trephine_operation* operation, uint64_t tick, trephine_error* error);
/* Replays the whole session from its beginning. Returns TREPHINE_DIFFERENT, with location and values, if
 * forces or voxels differ from the recording; TREPHINE_FAILED if they cannot be compared: the file is damaged
 * or unreadable, or was recorded by a program with another arithmetic. */
int trephine_operation_verify(trephine_operation* operation, trephine_error* error);

/* Returns 1 if the file was closed properly; 0 if its end was lost and only the part before is available. */
int trephine_operation_is_whole(const trephine_operation* operation);

/* ---- all operations ---- */
/* Number of ticks executed so far. */
uint64_t trephine_operation_tick(const trephine_operation* operation);
/* Number of recorded ticks; equal to trephine_operation_tick for operations of trephine_operation_begin. */
uint64_t trephine_operation_tick_count(const trephine_operation* operation);
size_t trephine_operation_hand_count(const trephine_operation* operation);
/* Writes the scene in the format of trephine_start::scene, at most `capacity` bytes including the terminating
 * 0. Returns the length without it. */
size_t trephine_operation_scene(const trephine_operation* operation, char* text, size_t capacity);
/* Returns the hash of the whole state: equal states have equal hashes. The cost grows with removed matter. */
uint64_t trephine_operation_hash(trephine_operation* operation);
/* Number of events; undo removes no events. */
size_t trephine_operation_event_count(const trephine_operation* operation);
/* Events (oldest first), measures and bodies by index. Return TREPHINE_BAD_ARGUMENT beyond the last. */
int trephine_operation_event(const trephine_operation* operation, size_t index, trephine_event* event);
size_t trephine_operation_measure_count(const trephine_operation* operation);
int trephine_operation_measure(const trephine_operation* operation, size_t index, trephine_measure* measure);
size_t trephine_operation_body_count(const trephine_operation* operation);
int trephine_operation_body(const trephine_operation* operation, size_t index, trephine_body* body);
/* Returns 1 and the box low .. high (inclusive) of the anatomy's voxels that may have changed since the last
 * call; 0 if no voxels changed. */
int trephine_operation_changed(trephine_operation* operation, int low[3], int high[3]);
/* Reads the current intensities of the box low .. high (inclusive), x fastest. A voxel approaches air (-1000
 * HU; the lowest value of other scans) in proportion to its removed share. */
int trephine_operation_read(const trephine_operation* operation, const int low[3], const int high[3],
                            int16_t* intensities, trephine_error* error);

#ifdef __cplusplus
}
#endif
#endif
