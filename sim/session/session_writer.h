// SessionWriter: records a session while it runs.
#pragma once

#include <atomic>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "sim/session/checkpoint_format.h"
#include "sim/session/session_format.h"

namespace trephine::sim {

struct WriterOptions {
  bool is_embedding = false;           ///< the file also contains the volumes
  bool wants_realtime = true;          ///< the writing thread gets real-time priority if permitted
  double block_seconds = 0.025;        ///< s between writes: bounds the loss of a killed program
  bool is_removed_when_empty = false;  ///< finish() deletes the file unless has_edits()
  /// s between syncs: bounds the loss by a power cut. Ends of strokes and commands are synced at once.
  double sync_seconds = 1;
  /// Work of a replay from one checkpoint to the next (CheckpointMaker::k_work); 0: no checkpoints.
  int checkpoint_work = CheckpointMaker::k_work;
};

/// End of a session, for its continuation.
struct SessionTail {
  std::uint64_t length = 0;      ///< bytes of whole blocks
  std::uint64_t blocks = 0;      ///< number of blocks of all kinds
  std::uint64_t log_blocks = 0;  ///< number of blocks of the log
  TypeList types;
  CheckpointTail checkpoints = {};
};

/// Lock on a recorded session: while it exists, no other trephine can write the session. Acquire it before
/// reading a session that will be continued.
class SessionLock {
 public:
  /// Error if the file does not exist, or another program has locked it.
  static Result<SessionLock> acquire(const std::string& path);
  SessionLock(SessionLock&& other) noexcept : file_(std::exchange(other.file_, -1)), path_(other.path_) {}
  SessionLock& operator=(SessionLock&&) = delete;
  ~SessionLock();

 private:
  friend class SessionWriter;
  SessionLock(int file, std::string path) : file_(file), path_(std::move(path)) {}
  int file_;
  std::string path_;
};

/// Appends checksummed blocks on a thread of its own; add() does not wait for the disk unless begin() permits
/// it. The first failure, such as a full disk, ends the recording, but not the operation: the written part
/// stays readable. Call add() from one thread, the edit thread. The file stays locked for other writers.
class SessionWriter {
 public:
  /// Creates the file; never overwrites an existing one. Shares ownership of the scan. Adds the modules of
  /// the catalogue to the header.
  static Result<std::unique_ptr<SessionWriter>> create(const std::string& path, SessionHeader header,
                                                       const SceneData& data, const Catalogue& catalogue,
                                                       const WriterOptions& options = {});
  /// Continues a file after its last whole block. `tail`: from Replay::tail(), read under the lock; its types
  /// must include all of the catalogue's, except those of procedures.
  static Result<std::unique_ptr<SessionWriter>> append(SessionLock lock, SessionTail tail,
                                                       const Catalogue& catalogue,
                                                       const WriterOptions& options = {});
  /// True while a program writes this file.
  static bool is_being_written(const std::string& path);
  ~SessionWriter();
  SessionWriter(const SessionWriter&) = delete;
  SessionWriter& operator=(const SessionWriter&) = delete;

  /// Starts making checkpoints, unless checkpoint_work is 0. The servos have the options `force`, and begin
  /// at `first_tick` with the current state of the engine. `may_wait`: if too many checkpoints wait to be
  /// encoded, add() waits instead of postponing the next checkpoint.
  void begin(const Engine& engine, const haptics::ForceOptions& force, double rate_hz,
             std::uint64_t first_tick, bool may_wait);
  /// Records a tick and its outcome.
  void add(const haptics::ServoRecord& record, Engine& engine, const Outcome& outcome);
  /// Records a command that the engine has applied, or that the procedure refused; ignores other refused
  /// commands.
  void add(const Command& command, Engine& engine, const Outcome& outcome);
  /// True if the operation was changed, or an event other than a fault was emitted.
  bool has_edits() const noexcept { return has_edits_.load(); }
  /// Writes the rest and the end, syncs and closes. Returns the first failure of the whole recording.
  Status finish(const Engine& engine);
  /// Returns the first failure so far.
  Status status() const;
  /// Number of syncs, which protect the file against a power cut.
  int sync_count() const noexcept { return sync_count_.load(); }
  std::uint64_t bytes_written() const noexcept { return bytes_written_.load(); }

 private:
  SessionWriter(int file, std::string path, TypeList types, const WriterOptions& options);
  void record_outcome(const Engine& engine, const Outcome& outcome);
  void seal_if_long();
  void seal();
  void record_checkpoint(Engine& engine);
  std::optional<std::uint64_t> block_for_checkpoint();
  void encode_checkpoints(std::unique_lock<std::mutex>& guard);
  void request_sync(const Engine& engine);
  void write_loop();
  void background_loop();
  void write_items(std::unique_lock<std::mutex>& guard);
  void write_block(BlockKind kind, std::uint64_t first_tick, const std::string& payload);
  void fail(int error_number);
  void stop_threads();

  int file_;
  std::string path_, where_;
  WriterOptions options_;
  /// The scans of a new session; empty once the hash and, if requested, the volumes are written.
  std::vector<std::shared_ptr<const volume::Volume>> volumes_;
  mutable std::mutex lock_;  ///< of items and requests; locked only while copying
  std::mutex file_lock_;
  std::condition_variable write_wake_, background_wake_, encoded_;
  ItemEncoder items_;
  std::vector<std::pair<std::uint64_t, std::string>> sealed_;  ///< complete blocks, with their first ticks
  std::shared_ptr<const volume::Version> version_to_hash_;     ///< published with the serial `hashed_serial_`
  std::uint64_t log_blocks_ = 0;                               ///< number of complete blocks of the log
  CheckpointTail tail_;
  std::unique_ptr<CheckpointMaker> maker_;      ///< of the adding thread
  std::unique_ptr<CheckpointEncoder> encoder_;  ///< of the background thread
  bool may_wait_ = false;
  std::vector<std::unique_ptr<Checkpoint>> pending_checkpoints_;  ///< complete checkpoints
  /// Encoded checkpoints with their ticks, to be written after the sealed blocks.
  std::vector<std::pair<std::uint64_t, std::string>> checkpoints_;
  bool wants_sync_ = false, is_sync_due_ = false, is_stopping_ = false;
  Status status_;
  std::uint64_t next_block_ = 0, last_tick_ = 0, hashed_serial_ = 0;
  std::vector<std::optional<std::uint64_t>> next_ticks_;  ///< per hand: next expected tick, if known
  bool is_appended_ = false;
  std::uint64_t dropped_ = 0;  ///< ticks missing between those added
  std::uint64_t ticks_ = 0;    ///< one past the newest tick of the session
  bool was_in_stroke_ = false;
  std::atomic<std::uint64_t> bytes_written_{0};
  std::atomic<bool> has_edits_{false};
  std::atomic<int> sync_count_{0};
  std::thread writer_, background_;
};

}  // namespace trephine::sim
