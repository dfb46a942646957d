/* Operate from C, or from any program that loads a library: a scene from text, hands with instruments, cuts,
 * commands, undo, events, and sessions that are recorded and opened again.
 *
 * Lengths mm, forces N, time s; world frame; errors as in haptics/c_api/c_api.h. Nothing throws, prints or
 * exits.
 *
 * Threads: an operation belongs to one thread at a time; operations share nothing. One step is one servo tick
 * of each hand and the edits that follow from it, so that it takes longer while bone is cut; the same poses
 * and commands give the same bits on every machine.
 *
 * Order of destruction: any. An operation needs no other object of this interface. The voxels are borrowed:
 * they stay where they are, unchanged, until it is destroyed. Models, texts and poses are copied. To destroy
 * an operation ends its recording first. */
#ifndef TREPHINE_APPS_C_API_OPERATION_H
#define TREPHINE_APPS_C_API_OPERATION_H

#include <haptics/c_api/c_api.h>

#ifdef __cplusplus
extern "C" {
#endif

#define TREPHINE_OPERATION_ABI_VERSION 1

typedef struct trephine_operation trephine_operation;

/* Intensities of size[0] * size[1] * size[2] voxels, x fastest, and the displacement (mm) of one voxel step
 * along x, then y, then z. `labels` may be NULL. */
typedef struct trephine_voxels {
  const int16_t* intensities;
  const uint8_t* labels;
  int size[3];
  double origin[3];
  double axes[9];
  int is_hounsfield; /* CT: what is cut becomes -1000 */
} trephine_voxels;

/* A polygonal model: vertices (mm, x y z each), triangles of three vertices, counter-clockwise from outside.
 */
typedef struct trephine_model {
  const double* vertices;
  size_t vertex_count;
  const uint32_t* triangles;
  size_t triangle_count;
} trephine_model;

/* What an operation starts from. All that is not set may be 0. */
typedef struct trephine_start {
  /* Lines of key=value: structures, hands, options; docs/file-formats.md, "A scene in text", has all keys.
   * Empty lines and lines that begin with '#' are left out; "volume" and "model" may be. The shortest for a
   * burr: "structure=bone\nlow=300\nhand=burr\nparameters=diameter=4" */
  const char* scene;
  const trephine_voxels* volumes; /* the anatomy, which alone is cut, first */
  size_t volume_count;
  const trephine_model* models;
  size_t model_count;
  const char* record; /* a new file, or NULL: nothing is recorded */
  int is_embedding;   /* the volumes go into that file too */
} trephine_start;

typedef struct trephine_pose {
  double position[3];
  double rotation[4]; /* a unit quaternion w x y z; all 0: not turned */
  uint32_t buttons;   /* bit 0: the instrument works */
} trephine_pose;

typedef struct trephine_event {
  uint64_t tick;
  int hand;
  double place[3];
  char name[64];
  char words[400]; /* "depth=0.2 structure=dura", cut where it is longer */
} trephine_event;

typedef struct trephine_measure {
  char name[128]; /* "removed", "strokes", "nearest to dura", ... */
  char unit[16];  /* "mm3"; empty: none */
  double value;
} trephine_measure;

/* Something that came off. Its surface (as in trephine_model, in the frame in which it was freed) stays where
 * it is until the next step, command or move of this operation. */
typedef struct trephine_body {
  uint32_t id; /* of commands: "hold-body" with "body=3" */
  int holder;  /* a hand, or -1: it lies still */
  double mm3;
  double position[3]; /* of that frame now */
  double rotation[4];
  trephine_model surface;
} trephine_body;

/* TREPHINE_OPERATION_ABI_VERSION of the library that was loaded. */
uint32_t trephine_operation_abi_version(void);

/* An operation at its beginning. NULL on failure. */
trephine_operation* trephine_operation_begin(const trephine_start* start, trephine_error* error);
/* A recorded one, at its beginning, to be looked at; volumes that the file does not hold are given, the
 * anatomy first. NULL on failure. */
trephine_operation* trephine_operation_open(const char* session, const trephine_voxels* volumes,
                                            size_t volume_count, trephine_error* error);
/* NULL is fine. */
void trephine_operation_destroy(trephine_operation* operation);

/* ---- of one that was begun ---- */
/* One tick: a pose of each hand, in their order; what each felt, when `touches` is not NULL. A position that
 * is no number gives no force and a latched fault. */
int trephine_operation_step(trephine_operation* operation, const trephine_pose* poses,
                            trephine_touch* touches, trephine_error* error);
/* A command by name, with its parameters in words: "undo", "redo", "note" with "text=\"two words\"", "burr"
 * with "diameter=3", "free-pieces", "hold-body" with "body=1", ...: `trephine modules` lists them. Work that
 * takes longer (a job) is done before this returns. TREPHINE_REFUSED when it may not be done now, which
 * changes nothing; undo and redo with nothing to take back are done, and change nothing either. A job whose
 * result cannot be used (nothing came off) is told by an event "job-discarded". */
int trephine_operation_command(trephine_operation* operation, int hand, const char* command,
                               const char* words, trephine_error* error);
/* Faults, contact and force are forgotten with the next step: after a pose that was no number there is no
 * force until then. */
int trephine_operation_reset(trephine_operation* operation);
/* Ends the recording and makes it safe; TREPHINE_FAILED with the first failure of all of it. Afterwards
 * nothing more can be done, only asked. Without a recording nothing but that. */
int trephine_operation_end(trephine_operation* operation, trephine_error* error);

/* ---- of one that was opened ---- */
/* Forward or back to where `tick` ticks were done, 0: its beginning; from the last one on: to its very end,
 * with the commands after it. */
int trephine_operation_go_to(trephine_operation* operation, uint64_t tick, trephine_error* error);
/* Plays all of it from its beginning. TREPHINE_DIFFERENT, with where and what, when forces or voxels were
 * others than those recorded; TREPHINE_FAILED when that cannot be said: the file is damaged or cannot be
 * read, or was recorded by a program of another arithmetic. */
int trephine_operation_verify(trephine_operation* operation, trephine_error* error);

/* 1 when the file was closed in order; 0 when its end was lost: what lies before that is there. */
int trephine_operation_is_whole(const trephine_operation* operation);

/* ---- of both ---- */
/* Ticks that were done up to now. */
uint64_t trephine_operation_tick(const trephine_operation* operation);
/* The same; of one that was opened: that are recorded in all. */
uint64_t trephine_operation_tick_count(const trephine_operation* operation);
size_t trephine_operation_hand_count(const trephine_operation* operation);
/* The scene as it was made, as trephine_start::scene has it. At most `capacity` bytes with the 0 at the end
 * are written; the length without it. */
size_t trephine_operation_scene(const trephine_operation* operation, char* text, size_t capacity);
/* Of all state: equal states, equal hashes. Takes longer the more was cut. */
uint64_t trephine_operation_hash(trephine_operation* operation);
/* Events, oldest first; undo takes none back. TREPHINE_BAD_ARGUMENT beyond the last. */
size_t trephine_operation_event_count(const trephine_operation* operation);
int trephine_operation_event(const trephine_operation* operation, size_t index, trephine_event* event);
size_t trephine_operation_measure_count(const trephine_operation* operation);
int trephine_operation_measure(const trephine_operation* operation, size_t index, trephine_measure* measure);
size_t trephine_operation_body_count(const trephine_operation* operation);
int trephine_operation_body(const trephine_operation* operation, size_t index, trephine_body* body);
/* 1, with the box (both ends included) of the anatomy's voxels that may look different since the last call; 0
 * when there is none. */
int trephine_operation_changed(trephine_operation* operation, int low[3], int high[3]);
/* Intensities as they are now, x fastest, of the box low .. high (both included): a voxel goes toward air
 * (-1000 HU; the lowest value of other scans) in proportion to what was removed of it. */
int trephine_operation_read(const trephine_operation* operation, const int low[3], const int high[3],
                            int16_t* intensities, trephine_error* error);

#ifdef __cplusplus
}
#endif
#endif
