// Checkpoint: the state of an operation at one moment of its session, from which the session can be opened
// without a replay of the part before.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "sim/engine/engine.h"
#include "sim/session/servo_follower.h"

namespace trephine::sim {

/// State of the engine at a position of the log, and of the servo some ticks later, when every hand has
/// adopted that state: older states, which a servo may use until then, need not be stored.
struct Checkpoint {
  std::uint64_t block = 0;  ///< block of the log that begins there
  EngineImage image;
  /// Ticks from there on, until every hand has adopted the state; exact.
  std::vector<haptics::ServoRecord> records;
  /// Core of each hand after the last of these ticks (ServoMemory).
  std::vector<std::string> cores;
  std::uint64_t next_tick = 0;  ///< after the last of these ticks
  /// Offset fields of tools that were built from older states, and adopted later.
  struct Fields {
    std::uint64_t serial = 0;
    std::uint8_t hand = 0;
    OffsetFields offsets;
  };
  std::vector<Fields> fields;
};

/// Makes checkpoints during an operation, at a spacing that takes some hundredths of a second to replay. The
/// spacing is estimated by counts, so that equal operations have equal checkpoints. Must be informed of
/// everything that the engine has applied, in order. For one thread.
class CheckpointMaker {
 public:
  CheckpointMaker(const Engine& engine, const haptics::ForceOptions& force, double dt,
                  std::uint64_t first_tick, int work = k_work);
  /// Default spacing, in ticks without contact; ticks with contact count more, cuts even more.
  static constexpr int k_work = 8000;
  /// Largest number of ticks to wait for servos that lag behind; then the checkpoint is given up.
  static constexpr std::size_t k_max_records = 1024;

  void add(const haptics::ServoRecord& record, const Engine& engine, const Outcome& outcome);
  void add(const Command& command, const Engine& engine, const Outcome& outcome);
  /// True if a checkpoint is due: call begin() with the block of the log that begins here.
  bool is_due() const noexcept { return is_faithful_ && !pending_ && work_ >= work_between_; }
  void begin(Engine& engine, std::uint64_t block);
  /// Returns a complete checkpoint, or null.
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
  std::vector<bool> has_adopted_;  ///< per hand: its servo uses the stored state or a newer one
  bool is_servo_done_ = false, are_fields_done_ = false;
};

}  // namespace trephine::sim
