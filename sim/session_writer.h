// Writes a session while it happens.
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

#include "sim/checkpoint_format.h"
#include "sim/session_format.h"

namespace trephine::sim {

struct WriterOptions {
  bool is_embedding = false;           ///< the volumes go into the file too
  bool wants_realtime = true;          ///< writes go before ordinary threads, when allowed
  double block_seconds = 0.025;        ///< what a killed program can lose is this and a scheduler's whim
  bool is_removed_when_empty = false;  ///< nothing was cut: finish() takes the file away again
  double sync_seconds = 1;  ///< what a power cut can lose; ends of strokes and commands are synced at once
  /// Work of a replay from one checkpoint to the next (CheckpointMaker::k_work); 0: none are made.
  int checkpoint_work = CheckpointMaker::k_work;
};

/// End of a session, for its continuation.
struct SessionTail {
  std::uint64_t length = 0;      ///< bytes of whole blocks
  std::uint64_t blocks = 0;      ///< of all kinds
  std::uint64_t log_blocks = 0;  ///< of the log
  TypeList types;
  CheckpointTail checkpoints = {};
};

/// A recorded session that no other program writes while this lives. Take it before reading what will be
/// gone on with.
class SessionLock {
 public:
  /// Error when there is no such file, or another program has it.
  static volume::Result<SessionLock> take(const std::string& path);
  SessionLock(SessionLock&& other) noexcept : file_(std::exchange(other.file_, -1)), path_(other.path_) {}
  SessionLock& operator=(SessionLock&&) = delete;
  ~SessionLock();

 private:
  friend class SessionWriter;
  SessionLock(int file, std::string path) : file_(file), path_(std::move(path)) {}
  int file_;
  std::string path_;
};

/// Appends checksummed blocks from a thread of its own; callers that add items never wait for the disk. The
/// first failure (a full disk) ends the recording, not the session: what was written stays readable.
/// add() from one thread, the edit thread. While it lives no other writer can take the file.
class SessionWriter {
 public:
  /// Creates the file; an existing one is never overwritten. Borrows nothing: the scan is held. The modules
  /// of the catalogue go into the header.
  static volume::Result<std::unique_ptr<SessionWriter>> create(const std::string& path, SessionHeader header,
                                                               const SceneData& data,
                                                               const Catalogue& catalogue,
                                                               const WriterOptions& options = {});
  /// Goes on with a file after its last whole block (Replay::tail() says, of what was read under the lock).
  /// Its types must hold all of the catalogue's.
  static volume::Result<std::unique_ptr<SessionWriter>> append(SessionLock lock, SessionTail tail,
                                                               const Catalogue& catalogue,
                                                               const WriterOptions& options = {});
  /// Does some program write this file at the moment?
  static bool is_being_written(const std::string& path);
  ~SessionWriter();
  SessionWriter(const SessionWriter&) = delete;
  SessionWriter& operator=(const SessionWriter&) = delete;

  /// Servos of such options begin at `first_tick` with what the engine says now. Checkpoints are made from
  /// here on; none unless set. `may_wait`: the caller that adds waits for those that are not written yet
  /// rather than go without the next.
  void begin(const Engine& engine, const haptics::ForceOptions& force, double rate_hz,
             std::uint64_t first_tick, bool may_wait);
  /// A tick and what the engine made of it.
  void add(const haptics::ServoRecord& record, Engine& engine, const Outcome& outcome);
  /// A command that the engine has applied; one that it refused is left out.
  void add(const Command& command, Engine& engine, const Outcome& outcome);
  /// Was anything cut?
  bool has_edits() const noexcept { return has_edits_.load(); }
  /// Writes the rest and the end, syncs and closes. The first failure of the whole recording, if any.
  volume::Status finish(const Engine& engine);
  /// The first failure so far.
  volume::Status status() const;
  /// Number of times that the file was made safe against a power cut.
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
  void ask_sync(const Engine& engine);
  void write_loop();
  void background_loop();
  void write_items(std::unique_lock<std::mutex>& guard);
  void write_block(BlockKind kind, std::uint64_t first_tick, const std::string& payload);
  void fail(int error_number);
  void stop_threads();

  int file_;
  std::string path_, where_;
  WriterOptions options_;
  std::shared_ptr<const volume::Volume> scan_;  ///< until its hash is written
  mutable std::mutex lock_;                     ///< items and requests; held for copies only
  std::mutex file_lock_;
  std::condition_variable write_wake_, background_wake_, encoded_;
  ItemEncoder items_;
  std::vector<std::pair<std::uint64_t, std::string>> sealed_;  ///< full blocks, with their first ticks
  std::shared_ptr<const volume::Version> to_hash_;             ///< published by `hashed_serial_`
  std::uint64_t log_blocks_ = 0;                               ///< whose items are complete
  CheckpointTail tail_;
  std::unique_ptr<CheckpointMaker> maker_;      ///< of the adding thread
  std::unique_ptr<CheckpointEncoder> encoder_;  ///< of the background thread
  bool may_wait_ = false;
  std::vector<std::unique_ptr<Checkpoint>> to_encode_;  ///< complete
  /// In bytes, with their ticks; to be written after what is sealed.
  std::vector<std::pair<std::uint64_t, std::string>> checkpoints_;
  bool wants_sync_ = false, is_sync_due_ = false, is_stopping_ = false;
  volume::Status status_;
  std::uint64_t next_block_ = 0, last_tick_ = 0, hashed_serial_ = 0;
  std::vector<std::optional<std::uint64_t>> next_ticks_;  ///< of each hand, once it is known
  bool is_appended_ = false;
  std::uint64_t dropped_ = 0;  ///< ticks missing between those added
  std::uint64_t ticks_ = 0;    ///< one past the newest of the session
  bool was_in_stroke_ = false;
  std::atomic<std::uint64_t> bytes_written_{0};
  std::atomic<bool> has_edits_{false};
  std::atomic<int> sync_count_{0};
  std::thread writer_, background_;
};

}  // namespace trephine::sim
