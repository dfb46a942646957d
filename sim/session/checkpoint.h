// Checkpoint: the state of an operation at one moment of its session. The session can be opened at this
// moment without a replay of the earlier part.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "sim/engine/engine.h"
#include "sim/session/servo_follower.h"

namespace trephine::sim {

/// State of the engine at a position of the log, and state of the servo some ticks later, when every hand has
/// adopted the engine's state. A servo may use older states until then; these need not be stored.
struct Checkpoint {
  std::uint64_t block = 0;  ///< index of the block of the log that begins at this position
  EngineSnapshot snapshot;
  /// Ticks from this position on, until every hand has adopted the state. Their outputs are exact, unlike
  /// those in the log.
  std::vector<haptics::ServoRecord> records;
  /// Core of each hand after the last of these ticks (ServoMemory).
  std::vector<std::string> cores;
  std::uint64_t next_tick = 0;  ///< after the last of these ticks
  /// Offset fields that were derived from the state at the position or an earlier state, and adopted after
  /// the position.
  struct Fields {
    std::uint64_t serial = 0;
    std::uint8_t hand = 0;
    OffsetFields offsets;
  };
  std::vector<Fields> fields;
};

/// Makes checkpoints during an operation. A replay from one checkpoint to the next takes some hundredths of a
/// second. This time is estimated by counts, so that equal operations have equal checkpoints. Call add() for
/// every tick and command that the engine has applied, in order. For one thread.
class CheckpointMaker {
 public:
  CheckpointMaker(const Engine& engine, const haptics::ForceOptions& force, double dt,
                  std::uint64_t first_tick, int work = k_work);
  /// Default work of a replay between two checkpoints, in ticks without contact. Ticks with contact count
  /// more, and cuts still more.
  static constexpr int k_work = 8000;
  /// Largest number of ticks to wait until all servos have adopted the state; then the checkpoint is
  /// discarded.
  static constexpr std::size_t k_max_records = 1024;

  void add(const haptics::ServoRecord& record, const Engine& engine, const Outcome& outcome);
  void add(const Command& command, const Engine& engine, const Outcome& outcome);
  /// True if a checkpoint is due: call begin() with the block of the log that begins here.
  bool is_due() const noexcept { return is_faithful_ && !pending_ && work_ >= work_between_; }
  void begin(Engine& engine, std::uint64_t block);
  /// Returns the begun checkpoint once it is complete; otherwise null.
  std::unique_ptr<Checkpoint> fetch_checkpoint();
  /// True while the followed cores reproduce the servo's output; otherwise no more checkpoints are made.
  bool is_faithful() const noexcept { return is_faithful_; }

 private:
  void finish_servo();
  void count(int work) noexcept;

  ServoFollower servo_;
  bool is_faithful_ = true;
  int work_between_, work_ = 0;
  std::unique_ptr<Checkpoint> pending_;
  std::vector<bool> has_adopted_;  ///< per hand: the servo uses the stored state or a newer one
  bool is_servo_done_ = false, are_fields_done_ = false;
};

}  // namespace trephine::sim
